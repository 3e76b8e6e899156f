"""The whole run in figures: modes and events on a timeline, the loop's timing. Import this module only to draw."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from tendond.offline.logs.events import KINDS, events, mode_spans
from tendond.offline.logs.log import LogFile
from tendond.offline.plots.style import OURS, PAPERS, save, style
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
NARROW = 0.08
"""Fraction of the whole time below which a stretch has no room for its name."""

SIZE = (10.0, 3.6)  # [inch]


def timeline(log: LogFile) -> Figure:
    """Modes as bands, events as marks, a row for each kind."""
    with style():
        figure = Figure(SIZE, layout="constrained")
        axes = figure.subplots()
        for start, end, mode in mode_spans(log.records):
            axes.axvspan(start, end, color=MODE_COLOURS[mode], lw=0)
            if end - start > NARROW * (_span(log)[1] - _span(log)[0]):
                axes.text(start, len(KINDS) - 0.45, f" {mode.value}", fontsize=8, va="bottom", clip_on=True)
        found = events(log.records)
        for row, kind in enumerate(reversed(KINDS)):
            at = [event.time for event in found if event.kind == kind]
            axes.plot(at, [row] * len(at), "|", color=PAPERS if kind == "fault" else OURS, ms=12, mew=1.5)
        axes.set(
            xlabel="time [s]",
            yticks=range(len(KINDS)),
            yticklabels=reversed(KINDS),
            ylim=(-0.6, len(KINDS) - 0.1),
            xlim=_span(log),
            title="Modes and events",
        )
    return figure


def loop_timing(log: LogFile) -> Figure:
    """Work and lateness of every cycle, and how they are distributed."""
    with style():
        figure = Figure(SIZE, layout="constrained")
        over_time, distribution = figure.subplots(1, 2, width_ratios=(2, 1))
        if not log.timings:
            over_time.text(0.5, 0.5, "no clock ran: lockstep or replay", ha="center", transform=over_time.transAxes)
        period = log.config.loop.period
        at = [timing.tick * period for timing in log.timings]
        series = {
            "work": (np.array([timing.work_us for timing in log.timings]) / 1000.0, OURS),
            "lateness": (np.array([timing.lateness_us for timing in log.timings]) / 1000.0, PAPERS),
        }
        for name, (values, colour) in series.items():
            if values.size:
                p99 = float(np.percentile(values, 99))
                over_time.plot(at, values, color=colour, lw=0.8, label=f"{name}, p99 {p99:.2f} ms")
                distribution.hist(values, bins=60, histtype="step", color=colour, log=True)
        if log.timings:
            over_time.legend(loc="upper right", fontsize=9)
        over_time.set(xlabel="time [s]", ylabel="[ms]", title="Loop timing", xlim=_span(log))
        distribution.set(xlabel="[ms]", ylabel="cycles")
        if log.timings:
            distribution.yaxis.set_major_formatter("{x:g}")  # 100, not 10²: a formula takes a tenth of a second
            distribution.yaxis.set_minor_formatter(NullFormatter())
    return figure


def draw_timeline(log: LogFile, folder: Path, suffix: str = "png") -> list[Path]:
    """Draw both into `folder`, which is made."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    with style():
        for name, figure in (("timeline", timeline(log)), ("timing", loop_timing(log))):
            paths.append(folder / f"{name}.{suffix}")
            save(figure, paths[-1])
    return paths


def _span(log: LogFile) -> tuple[float, float]:
    first, last = log.records[0].time, log.records[-1].time
    return first, max(last, first + log.config.loop.period)
