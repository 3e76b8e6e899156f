"""Heat maps of settling and ripple over delay and lag. Import this module only to draw: it needs the extra `plot`."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.typing import ColorType
from numpy.typing import NDArray

from tendond.offline.files import whole
from tendond.offline.robustness.evaluate import RIPPLE_GOAL_MM, SETTLING_GOAL, PointResult
from tendond.offline.robustness.points import AXES, FEEDBACKS, Point
from tendond.offline.robustness.run import Rows

Array = NDArray[np.float64]

DELAYS = tuple(int(value) for value in AXES["delay_cycles"])
LAGS = tuple(float(value) for value in AXES["lag_factor"])
NAMES = {"force": "force observer", "offset": "offset observer", "direct": "no observer (direct)"}
MAP = "cividis_r"
"""Reads the same to the colour-blind and in grey: the darker, the worse."""


@dataclass(frozen=True)
class _Measure:
    """title, with its unit; what a result has of it; how it is written; its colours' norm and goal."""

    title: str
    value: Callable[[PointResult], float]
    text: Callable[[float], str]
    norm: Normalize
    goal: float


MEASURES = (
    _Measure(
        "settling [iterations]",
        lambda result: math.inf if result.settling_iterations is None else float(result.settling_iterations),
        "{:.0f}".format,
        Normalize(0.0, 2.0 * SETTLING_GOAL, clip=True),
        SETTLING_GOAL,
    ),
    _Measure(
        "ripple [mm]",
        lambda result: math.inf if result.ripple_mm is None else result.ripple_mm,
        lambda value: "<0.01" if value < 0.01 else f"{value:.0f}" if value >= 10.0 else f"{value:.2g}",
        LogNorm(RIPPLE_GOAL_MM / 100.0, RIPPLE_GOAL_MM * 100.0, clip=True),
        RIPPLE_GOAL_MM,
    ),
)


def draw(rows: Rows, path: Path) -> Path:
    """Draw the points whose controller knows delay and lag into a PNG file.

    A row for each law and measure; a column for each feedback with delay and lag alone, and one for each feedback
    that was run on more than these, with the worst of all points. Lags between the axis's values count with the
    next larger one.
    """
    rows = [(point, result) for point, result in rows if point.configured == "exact"]
    laws = list(dict.fromkeys(point.law for point, _ in rows))
    columns: list[tuple[str, str, bool]] = []
    for feedback in FEEDBACKS:
        own = [point for point, _ in rows if point.feedback == feedback]
        if any(_alone(point) for point in own):
            columns.append((NAMES[feedback], feedback, True))
        if any(point.part not in ("axes", "misconfigured") for point in own):
            columns.append((f"{NAMES[feedback]}\nworst of all {len(own) // len(laws)} plants", feedback, False))
    with rc_context({"font.size": 9, "axes.titlesize": 9, "savefig.dpi": 150}):
        figure = Figure((2.4 * len(columns) + 1.6, 1.9 * len(laws) * len(MEASURES) + 1.0), layout="constrained")
        grid = figure.subplots(len(laws) * len(MEASURES), len(columns), squeeze=False)
        for line, (law, measure) in enumerate((law, measure) for measure in MEASURES for law in laws):
            for column, (title, feedback, alone) in enumerate(columns):
                part = [row for row in rows if (row[0].law, row[0].feedback) == (law, feedback)]
                part = [row for row in part if _alone(row[0])] if alone else part
                axes = grid[line, column]
                _heat(axes, _table(part, measure), measure)
                if line == 0:
                    axes.set_title(title)
                if line == len(grid) - 1:
                    axes.set_xlabel("lag [fraction remaining after one cycle]")
                if column == 0:
                    axes.set_ylabel(f"{law.replace('_', ' ')}\n{measure.title}\n\ndelay [cycles]")
        figure.suptitle(
            f"Worst settling (goal: {SETTLING_GOAL} iterations) and ripple (goal: {RIPPLE_GOAL_MM} mm); "
            "framed cells are beyond the goal, '-' was not run",
            x=0.01,
            ha="left",
            fontsize=10,
        )
        with whole(path) as draft:
            figure.savefig(draft)
    return path


def _alone(point: Point) -> bool:
    """Check that a point differs from the nominal one by delay and lag only."""
    nominal = Point(point.part, point.law, point.feedback, delay_cycles=point.delay_cycles, lag_factor=point.lag_factor)
    return point == nominal


def _table(rows: Rows, measure: _Measure) -> Array:
    """Worst values, shape (delays, lags); NaN where there is no point."""
    values = np.full((len(DELAYS), len(LAGS)), np.nan)
    for point, result in rows:
        cell = DELAYS.index(point.delay_cycles), int(np.searchsorted(LAGS, point.lag_factor - 1e-9))
        values[cell] = np.fmax(values[cell], measure.value(result))
    return values


def _heat(axes: Axes, values: Array, measure: _Measure) -> None:
    colours = colormaps[MAP]
    for (row, column), value in np.ndenumerate(values):
        known, never = not math.isnan(value), math.isinf(value)
        shade = float(measure.norm(min(value, 1e6))) if known else 0.0
        face = "black" if never else colours(shade) if known else "white"
        beyond = known and value > measure.goal
        axes.add_patch(_cell(column, row, face, "#d55e00" if beyond else "none"))
        text = "-" if not known else "never" if never else measure.text(value)
        dark = never or shade > 0.5
        axes.text(column, row, text, ha="center", va="center", color="white" if dark else "black", fontsize=8)
    axes.set(xlim=(-0.5, len(LAGS) - 0.5), ylim=(-0.5, len(DELAYS) - 0.5))
    axes.set_xticks(range(len(LAGS)), [f"{lag:g}" for lag in LAGS])
    axes.set_yticks(range(len(DELAYS)), [str(delay) for delay in DELAYS])
    axes.tick_params(length=0)


def _cell(column: int, row: int, face: ColorType, edge: str) -> Rectangle:
    return Rectangle((column - 0.46, row - 0.46), 0.92, 0.92, facecolor=face, edgecolor=edge, linewidth=2.0)
