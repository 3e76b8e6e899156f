"""The rod's shapes in its bending plane during a run. Import this module only to draw."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from numpy.typing import NDArray

from tendond.offline.logs.log import LogFile
from tendond.offline.logs.metrics import Tracking
from tendond.offline.plots.appearance import appearance
from tendond.offline.plots.panels import Panels
from tendond.offline.plots.style import DARK, PAPERS, gravity_arrow, legend_above, title

Array = NDArray[np.float64]

APART = 0.05
"""Smallest distance between the tips of two shapes that are drawn, as a fraction of the rod's length."""

COLOURS = LinearSegmentedColormap.from_list("shapes", ["#2b1055", "#31518f", "#2a8a8c", "#58b668", "#c9c32a"])
"""From dark to light, but not so light that a line on paper is lost."""


def draw_shapes(axes: Axes, log: LogFile, run: Tracking) -> None:
    """Draw the rod in its bending plane, whenever its tip is where none was drawn, with gravity down the page.

    Args:
        axes: the axes. log: the log. run: one of its runs.
    """
    gravity = np.array(log.config.rod.base_gravity)
    level_rod = abs(gravity[run.axis]) > abs(gravity[2])
    plane = [2, run.axis] if level_rod else [run.axis, 2]
    shown = Panels(log, run).shown
    kept = _spread(_moments(log, run, shown), plane, APART * log.config.rod.backbone_length)
    scale = appearance().unit_of_time(log.config.loop.period)
    last = max((cycle for cycle, _ in kept[:-1]), default=0)
    last = last if last > 0 else int(run.ticks[shown - 1] - run.ticks[0]) or 1
    colours = ScalarMappable(Normalize(0.0, scale * last), COLOURS)
    width = appearance().sizes.line_width
    drawn = [1e3 * points[:, plane] for _, points in kept]
    for i, ((cycle, _), line) in enumerate(zip(kept, drawn, strict=True)):
        final = i == len(kept) - 1
        axes.plot(
            *line.T,
            color="black" if final else colours.to_rgba(np.array([scale * max(cycle, 0)]))[0],
            lw=1.6 * width if final else 0.7 * width,
            label="rod at the end" if final else None,
        )
    path = 1e3 * run.tip[:shown, plane]
    axes.plot(*path.T, ":", color=DARK, lw=0.6 * width, label="path of the tip")
    target = 1e3 * np.array(run.target)[plane]
    size = appearance().points(8.0)
    axes.plot(*target, "x", color=PAPERS, ms=size, mew=0.22 * size, ls="", label="target")
    axes.plot(0.0, 0.0, "s", color=DARK, ms=0.6 * size)
    axes.set(xlabel=f"{'xyz'[plane[0]]} [mm]", ylabel=f"{'xyz'[plane[1]]} [mm]", aspect="equal")
    gravity_arrow(axes, gravity[plane], np.vstack([path, *drawn]))
    title(axes, "Rod while it moves")
    legend_above(axes, share=0.8)
    axes.figure.colorbar(colours, ax=axes, label=appearance().time_label, shrink=0.85)


def _moments(log: LogFile, run: Tracking, shown: int) -> list[tuple[int, Array]]:
    """Return cycle of the run and points of each recorded shape, from the last one before the run on [m]."""
    first = int(run.ticks[0])
    counted = [(tick - first, points) for tick, points in log.shapes]
    start = max((cycle for cycle, _ in counted if cycle <= 0), default=0)
    return [one for one in counted if start <= one[0] <= run.ticks[shown - 1] - first]


def _spread(moments: list[tuple[int, Array]], plane: list[int], apart: float) -> list[tuple[int, Array]]:
    """Select those whose tip is nowhere near one selected before, and the last one."""
    kept: list[tuple[int, Array]] = []
    for cycle, points in reversed(moments):  # from the end, so that the last one stays
        tips = [other[-1, plane] for _, other in kept]
        if all(np.linalg.norm(points[-1, plane] - tip) >= apart for tip in tips):
            kept.append((cycle, points))
    return sorted(kept, key=lambda one: one[0])
