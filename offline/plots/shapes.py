"""The rod's shapes in the plane of its motion during a run. Import this module only to draw."""

import math
from dataclasses import dataclass

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

LINE = 0.3
"""Largest spread of the tip beside a line through the base, by that along it, for which it moves in a plane. Chosen."""

NEAR_AXIS = 5.0
"""Angle of that line to an axis of the base frame below which it is that axis [degrees]. Chosen."""

ROOM = 0.3
"""Smallest width and height of what is shown, of the rod's length. Chosen."""

COLOURS = LinearSegmentedColormap.from_list("shapes", ["#2b1055", "#31518f", "#2a8a8c", "#58b668", "#c9c32a"])
"""From dark to light, but not so light that a line on paper is lost."""


@dataclass(frozen=True)
class View:
    """Directions of a drawing of the rod, in its base frame.

    Attributes:
        axes: the one across the page and the one up the page, shape (2, 3).
        labels: their names: 'x', 'z', or 'across'.
        remark: what 'across' is; empty for axes of the frame.
    """

    axes: Array
    labels: tuple[str, str]
    remark: str = ""

    @classmethod
    def of(cls, run: Tracking, gravity: Array) -> "View":
        """Choose the plane in which the tip moves; gravity, where it lies in it, points down or up the page.

        Args:
            run: the run. gravity: in the base frame [m/s^2], shape (3,).
        """
        across, name, remark = _across(run)
        level_rod = abs(gravity @ across) > abs(gravity[2])
        axes = np.array([[0.0, 0.0, 1.0], across] if level_rod else [across, [0.0, 0.0, 1.0]])
        return cls(axes, ("z", name) if level_rod else (name, "z"), remark)

    def seen(self, points: Array) -> Array:
        """Project points, shape (..., 3), onto the page, shape (..., 2)."""
        return np.asarray(points @ self.axes.T)


def _across(run: Tracking) -> tuple[Array, str, str]:
    """Return the direction across in which the tip moves, its name and what it is.

    That is the axis in which the run bends, unless tip and target lie along another line through the base.
    """
    aside = np.vstack([run.tip[:, :2], run.target[:2]])
    spread, directions = np.linalg.eigh(aside.T @ aside)
    line = directions[:, 1] * np.sign(directions[np.argmax(np.abs(directions[:, 1])), 1])
    degrees = math.degrees(math.atan2(line[1], line[0]))
    if spread[0] < LINE**2 * spread[1]:
        for axis in (0, 1):
            if abs(degrees - 90.0 * axis) < NEAR_AXIS:
                return np.eye(3)[axis], "xy"[axis], ""
        return np.array([*line, 0.0]), "across", f"across: {degrees:.0f}° from x towards y"
    return np.eye(3)[run.axis], "xy"[run.axis], ""


def draw_shapes(axes: Axes, log: LogFile, run: Tracking) -> None:
    """Draw the rod in the plane of its motion, whenever its tip is where none was drawn.

    Args:
        axes: the axes. log: the log. run: one of its runs.
    """
    gravity = np.array(log.config.rod.base_gravity)
    view = View.of(run, gravity)
    length = log.config.rod.backbone_length
    shown = Panels(log, run).shown
    kept = _spread([(cycle, view.seen(points)) for cycle, points in _moments(log, run, shown)], APART * length)
    scale = appearance().unit_of_time(log.config.loop.period)
    last = max((cycle for cycle, _ in kept[:-1]), default=0)
    last = last if last > 0 else int(run.ticks[shown - 1] - run.ticks[0]) or 1
    colours = ScalarMappable(Normalize(0.0, scale * last), COLOURS)
    width = appearance().sizes.line_width
    drawn = [1e3 * points for _, points in kept]
    for i, ((cycle, _), line) in enumerate(zip(kept, drawn, strict=True)):
        final = i == len(kept) - 1
        axes.plot(
            *line.T,
            color="black" if final else colours.to_rgba(np.array([scale * max(cycle, 0)]))[0],
            lw=1.6 * width if final else 0.7 * width,
            label="rod at the end" if final else None,
        )
    path = 1e3 * view.seen(run.tip[:shown])
    axes.plot(*path.T, ":", color=DARK, lw=0.6 * width, label="path of the tip")
    target = 1e3 * view.seen(np.array(run.target))
    size = appearance().points(8.0)
    axes.plot(*target, "x", color=PAPERS, ms=size, mew=0.22 * size, ls="", label="target")
    axes.plot(0.0, 0.0, "s", color=DARK, ms=0.6 * size)
    axes.set(xlabel=f"{view.labels[0]} [mm]", ylabel=f"{view.labels[1]} [mm]", aspect="equal")
    _leave_room(axes, 1e3 * ROOM * length)
    gravity_arrow(axes, view.seen(gravity), np.vstack([path, *drawn]))
    title(axes, f"Rod while it moves{f' ({view.remark})' if view.remark else ''}")
    legend_above(axes, share=0.8)
    axes.figure.colorbar(colours, ax=axes, label=appearance().time_label, shrink=0.85)


def _leave_room(axes: Axes, least: float) -> None:
    """Widen what is shown to a width and a height of `least`, about its middle: a straight rod has no width."""
    for get, change in ((axes.get_xlim, axes.set_xlim), (axes.get_ylim, axes.set_ylim)):
        low, high = get()
        more = max(0.0, least - (high - low)) / 2
        change(low - more, high + more)


def _moments(log: LogFile, run: Tracking, shown: int) -> list[tuple[int, Array]]:
    """Return cycle of the run and points of each recorded shape, from the last one before the run on [m]."""
    first = int(run.ticks[0])
    counted = [(tick - first, points) for tick, points in log.shapes]
    start = max((cycle for cycle, _ in counted if cycle <= 0), default=0)
    return [one for one in counted if start <= one[0] <= run.ticks[shown - 1] - first]


def _spread(moments: list[tuple[int, Array]], apart: float) -> list[tuple[int, Array]]:
    """Select those whose tip is nowhere near one selected before, and the last one."""
    kept: list[tuple[int, Array]] = []
    for cycle, points in reversed(moments):  # from the end, so that the last one stays
        tips = [other[-1] for _, other in kept]
        if all(np.linalg.norm(points[-1] - tip) >= apart for tip in tips):
            kept.append((cycle, points))
    return sorted(kept, key=lambda one: one[0])
