"""The paper's figures: tip, tendon and error over time. Import this module only to draw."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from tendond.offline.logs.metrics import SETTLED
from tendond.offline.paper.lyapunov import CAUSES, find_rises, rate_of
from tendond.offline.paper.run import PaperRun, Runs
from tendond.offline.paper.scenarios import DISTURBED_AT, start_of
from tendond.offline.plots.appearance import STYLES, appearance
from tendond.offline.plots.style import OURS, PAPERS, REFERENCE, headline, new_figure, save, style
from tendond.offline.plots.style import title as panel_title

Array = NDArray[np.float64]

Named = Sequence[tuple[str, str]]
"""Scenarios and what they are called in a figure."""

COLOURS = {"backstepping": OURS, "sliding_mode": PAPERS}
LIGHT = {"backstepping": "#7fb0de", "sliding_mode": "#f0b183"}
DARK = "#262626"
FOUR = (10.0, 6.6)  # [inch]

CAUSE_MARKS = {
    "limit": ("s", "#b2182b"),
    "rank": ("^", "#7b3294"),
    "sampled": ("o", "#1b7837"),
    "rest": (".", REFERENCE),
}


@dataclass(frozen=True)
class Line:
    """A run in a figure: its colour, dashes and label."""

    run: PaperRun
    colour: str
    label: str
    dashes: str = "-"
    width: float = 1.8


def name_of(law: str) -> str:
    """Return a law's name for people."""
    return law.replace("_", " ")


def unit_of(run: PaperRun) -> float:
    """Return what an iteration takes on the axis of time."""
    return appearance().unit_of_time(run.scenario.config.loop.period)


def both_laws(scenario: str, title: str, runs: Runs, path: Path) -> Path:
    """Draw x, z, displacement and error of both laws in one scenario."""
    lines = [
        Line(runs[scenario, "sliding_mode"], COLOURS["sliding_mode"], name_of("sliding_mode")),
        Line(runs[scenario, "backstepping"], COLOURS["backstepping"], name_of("backstepping"), "--"),
    ]
    return four_panels(lines, title, path, 100)


def loaded(normal: str, scenarios: Named, law: str, title: str, runs: Runs, path: Path) -> Path:
    """Draw x, z, displacement and error of one law with and without loads; `scenarios` are names and labels."""
    shades = [COLOURS[law]] if len(scenarios) == 1 else [LIGHT[law], COLOURS[law]]
    lines = [Line(runs[normal, law], REFERENCE, "no load", "-", 1.2)]
    lines += [Line(runs[name, law], shade, label) for (name, label), shade in zip(scenarios, shades, strict=True)]
    mark = DISTURBED_AT if len(scenarios) == 1 else None
    return four_panels(lines, title, path, 120, mark=mark)


def four_panels(lines: Sequence[Line], title: str, path: Path, shown: int, mark: int | None = None) -> Path:
    """Draw the paper's panels (a) to (d): x, z, displacement, error over time; `shown`, `mark` are iterations."""
    unit = unit_of(lines[0].run)
    with style():
        figure = new_figure(*FOUR)
        panels = zip("abcd", figure.subplots(2, 2).flat, (_x, _z, _displacement, _error), strict=True)
        for letter, axes, draw in panels:
            panel_title(axes, f"({letter}) {draw(axes, lines)}", letter=letter)
            axes.set(xlabel=appearance().time_label, xlim=(0, shown * unit))
            if mark is not None:
                axes.axvline(mark * unit, color=DARK, lw=0.8, ls=":")
        handles, labels = figure.axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False, handlelength=2.6)
        headline(figure, title)
        return save(figure, path)


def experiment_curves(scenarios: Named, title: str, runs: Runs, path: Path) -> Path:
    """x and z of each law, a row per law, as the paper shows its two experiments with loads."""
    with style():
        figure = new_figure(*FOUR)
        rows = figure.subplots(2, 2, sharex=True, sharey="col")
        for row, law in zip(rows, COLOURS, strict=True):
            shades = [COLOURS[law]] if len(scenarios) == 1 else [LIGHT[law], COLOURS[law]]
            lines = [
                Line(runs[name, law], shade, label) for (name, label), shade in zip(scenarios, shades, strict=True)
            ]
            for axes, draw, letter in zip(row, (_x, _z), "xz", strict=True):
                unit = unit_of(lines[0].run)
                draw(axes, lines)
                axes.set(xlim=(0, unit * (len(lines[0].run.tip) - 1)), title=f"{name_of(law)}: {letter} of the tip")
                for number, (at, size) in enumerate(pushes_of(lines[0].run)):
                    axes.axvline(unit * at, color=DARK, lw=0.8, ls=":")
                    if draw is _z:  # neighbours at two heights, so that their numbers do not meet
                        axes.annotate(f"{size:.1f} N", (unit * at, 1.0 - 0.08 * (number % 2)), (2, -2),
                                      xycoords=axes.get_xaxis_transform(), textcoords="offset points",
                                      fontsize=appearance().points(7), va="top", color=DARK)  # fmt: skip
            if len(lines) > 1:
                row[0].legend(loc="lower right", frameon=False)
        for axes in rows[-1]:
            axes.set_xlabel(appearance().time_label)
        headline(figure, title)
        return save(figure, path)


def force_found(scenarios: Named, title: str, runs: Runs, path: Path) -> Path:
    """Draw the force on the tip along x and the observer's estimate of it, a panel per scenario."""
    with style():
        figure = new_figure(10.0, 3.6)
        for axes, (name, label) in zip(figure.subplots(1, len(scenarios), sharey=True), scenarios, strict=True):
            unit = unit_of(runs[name, "backstepping"])
            for law, colour in reversed(COLOURS.items()):
                force = runs[name, law].force[:, 0]
                axes.plot(unit * np.arange(len(force)), force, color=colour, lw=1.8, label=f"estimate, {name_of(law)}",
                          ls="--" if law == "backstepping" else "-")  # fmt: skip
            truth = runs[name, "backstepping"].tip_force[:, 0]
            time = unit * np.arange(len(truth))
            axes.plot(time, truth, color=DARK, lw=1.0, ls=":", label="truth")
            axes.fill_between(time, 0.9 * truth, 1.1 * truth, color=REFERENCE, alpha=0.25, lw=0.0,
                              label="truth, ±10 %")  # fmt: skip
            axes.set(title=label, xlabel=appearance().time_label, xlim=(40 * unit, 160 * unit))
        figure.axes[0].set_ylabel("force on the tip along x [N]")
        figure.axes[-1].legend(loc="upper right", frameon=False)
        headline(figure, title)
        return save(figure, path)


def lyapunov(scenarios: Named, runs: Runs, path: Path) -> Path:
    """V of both laws, a row per scenario, with what theory promises and a mark wherever it rises."""
    with style():
        figure = new_figure(10.0, 3.3 * len(scenarios) + 0.6)
        rows = figure.subplots(len(scenarios), 2, sharex=True, squeeze=False)
        for row, (scenario, title) in zip(rows, scenarios, strict=True):
            for axes, law in zip(row, COLOURS, strict=True):
                _lyapunov(axes, runs[scenario, law])
                axes.set_title(f"{name_of(law)}: {title}")
        for axes in rows[-1]:
            axes.set_xlabel(appearance().time_label)
        handles = [
            axes.plot([], [], mark, color=colour, ms=5, ls="", label=CAUSES[cause].split(":")[0])[0]
            for cause, (mark, colour) in CAUSE_MARKS.items()
        ]
        handles.append(
            axes.plot([], [], "--", color=DARK, lw=1.0, label="theory: exp(-2 rate t), from its greatest value")[0]
        )
        figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False, title="V rises after a mark")
        headline(figure, "Lyapunov function of each law")
        return save(figure, path)


def pushes_of(run: PaperRun) -> list[tuple[int, float]]:
    """Iteration and size [N] of the impacts of a run's scenario."""
    config = run.scenario.config
    return [
        (round(impact.time / config.loop.period) - start_of(config), float(np.linalg.norm(impact.force)))
        for impact in config.simulator.impacts
    ]


def _lyapunov(axes: Axes, run: PaperRun) -> None:
    value, rises = run.lyapunov, find_rises(run)
    time = unit_of(run) * np.arange(len(value))
    axes.semilogy(time, value, color=COLOURS[run.law])
    top = int(np.nanargmax(value))
    after = np.arange(top, len(value))
    period = run.scenario.config.loop.period
    promised = value[top] * np.exp(-2.0 * rate_of(run) * period * (after - top))
    axes.semilogy(time[after], promised, "--", color=DARK, lw=1.0)
    for cause, (mark, colour) in CAUSE_MARKS.items():
        at = rises.of(cause)
        axes.plot(time[at], value[at], mark, color=colour, ms=4, ls="")
    axes.set(ylabel="V [m²/s²]", xlim=(0, time[-1]), ylim=(np.nanmin(value) / 10.0, 3.0 * value[top]))


def _x(axes: Axes, lines: Sequence[Line]) -> str:
    run = lines[-1].run
    target = 1e3 * run.target[0]
    _curves(axes, lines, lambda one: 1e3 * one.tip[:, 0])
    time = unit_of(run) * np.arange(len(run.reference))
    axes.plot(time, 1e3 * run.reference[:, 0], color=DARK, lw=1.0, ls=":", label="reference of x")
    axes.axhspan((1 - SETTLED) * target, (1 + SETTLED) * target, color=REFERENCE, alpha=0.15, lw=0, label="target ±5 %")
    axes.set_ylabel("tip x [mm]")
    return f"x of the tip, target {target:.0f} mm"


def _z(axes: Axes, lines: Sequence[Line]) -> str:
    target = 1e3 * lines[-1].run.target[2]
    axes.axhline(target, color=REFERENCE, lw=0.8)
    _curves(axes, lines, lambda run: 1e3 * run.tip[:, 2])
    axes.set_ylabel("tip z [mm]")
    return f"z of the tip, target {target:.1f} mm"


def _displacement(axes: Axes, lines: Sequence[Line]) -> str:
    _curves(axes, lines, lambda run: 1e3 * run.displacement)
    axes.set_ylabel("displacement [mm]")
    return "tendon displacement"


def _error(axes: Axes, lines: Sequence[Line]) -> str:
    _curves(axes, lines, lambda run: 1e3 * np.linalg.norm((run.reference - run.tip)[:, [0, 2]], axis=1))
    axes.set_ylabel("|reference - tip| [mm]")
    axes.set_ylim(bottom=0.0)
    return "position error"


def _curves(axes: Axes, lines: Sequence[Line], values: Callable[[PaperRun], Array]) -> None:
    for line in lines:
        drawn = values(line.run)
        time = unit_of(line.run) * np.arange(len(drawn))
        width = line.width * appearance().sizes.line_width / STYLES["default"].line_width
        axes.plot(time, drawn, line.dashes, color=line.colour, lw=width, label=line.label)
