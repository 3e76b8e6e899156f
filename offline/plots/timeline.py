"""The whole run in figures: modes and events on a timeline, the loop's timing. Import this module only to draw."""

from functools import partial

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from tendond.offline.logs.events import KINDS, events, mode_spans
from tendond.offline.logs.injections import injections
from tendond.offline.logs.log import LogFile
from tendond.offline.plots.appearance import appearance
from tendond.offline.plots.output import Named
from tendond.offline.plots.style import OURS, PAPERS, new_figure, style, title
from tendond.schemas.messages import Mode

MODE_COLOURS = {
    Mode.STARTING: "#e6e6e6",
    Mode.IDLE: "#e6e6e6",
    Mode.PROBE: "#ffe3ad",
    Mode.PRETENSION: "#ffe3ad",
    Mode.TRACKING: "#cfe6cf",
    Mode.RELEASING: "#d8dcf2",
    Mode.FAULT: "#f5c6c1",
}
INJECTED = "injected"
"""Name of the row of a simulator's loads and faults."""

NARROW = 0.08
"""Fraction of the whole time below which a stretch has no room for its name."""

SIZE = (10.0, 3.6)  # [inch]


def timeline(log: LogFile) -> Figure:
    """Modes as bands, events as marks, a row for each kind, what a simulator injected in a row of its own."""
    injected = [(one.start, one.end) for one in injections(log.truth_ticks, log.truth)]
    rows = [*([INJECTED] if injected else []), *reversed(KINDS)]
    first, last = _span(log)
    with style():
        figure = new_figure(*SIZE)
        axes = figure.subplots()
        for start, end, mode in mode_spans(log.records):
            axes.axvspan(start, end, color=MODE_COLOURS[mode], lw=0)
            if end - start > NARROW * (last - first):
                size = appearance().points(8)
                axes.text(start, len(rows) - 0.45, f" {mode.value}", fontsize=size, va="bottom", clip_on=True)
        found = events(log.records)
        mark = appearance().points(12)
        for row, kind in enumerate(rows):
            at = [event.time for event in found if event.kind == kind]
            axes.plot(at, [row] * len(at), "|", color=PAPERS if kind == "fault" else OURS, ms=mark, mew=1.5)
        period = log.config.loop.period
        for begun, ended in injected:
            until = last if ended is None else ended * period
            axes.plot([begun * period, until], [0, 0], color=PAPERS, lw=0.5 * mark, solid_capstyle="butt")
        axes.set(
            xlabel="time [s]",
            yticks=range(len(rows)),
            yticklabels=rows,
            ylim=(-0.6, len(rows) + 0.3),
            xlim=(first, last),
        )
        title(axes, "Modes and events")
    return figure


def loop_timing(log: LogFile) -> Figure:
    """Work and lateness of every cycle, and how they are distributed, of a log with timings: a clock ran."""
    with style():
        figure = new_figure(*SIZE)
        over_time, distribution = figure.subplots(1, 2, width_ratios=(2, 1))
        period = log.config.loop.period
        at = [timing.tick * period for timing in log.timings]
        series = {
            "work": (np.array([timing.work_us for timing in log.timings]) / 1000.0, OURS),
            "lateness": (np.array([timing.lateness_us for timing in log.timings]) / 1000.0, PAPERS),
        }
        for name, (values, colour) in series.items():
            if values.size:
                p99 = float(np.percentile(values, 99))
                early = "; below 0: begun by a pose" if name == "lateness" and values.min() < 0.0 else ""
                over_time.plot(at, values, color=colour, lw=0.8, label=f"{name}, p99 {p99:.2f} ms{early}")
                distribution.hist(values, bins=60, histtype="step", color=colour, log=True)
        if log.timings:
            over_time.legend(loc="upper right", fontsize=appearance().points(9))
        over_time.set(xlabel="time [s]", ylabel="work, lateness [ms]", xlim=_span(log))
        title(over_time, "Loop timing")
        distribution.set(xlabel="work, lateness [ms]", ylabel="cycles")
        if log.timings:
            distribution.yaxis.set_major_formatter("{x:g}")  # 100, not 10²: a formula takes a tenth of a second
            distribution.yaxis.set_minor_formatter(NullFormatter())
    return figure


def time_figures(log: LogFile) -> list[Named]:
    """Return the timeline, and the loop's timing where a clock ran."""
    timing = [Named("timing", partial(loop_timing, log))] if log.timings else []
    return [Named("timeline", partial(timeline, log)), *timing]


def _span(log: LogFile) -> tuple[float, float]:
    first, last = log.records[0].time, log.records[-1].time
    return first, max(last, first + log.config.loop.period)
