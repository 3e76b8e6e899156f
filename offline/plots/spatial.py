"""A run in space as a figure: in perspective, and from two sides. Import this module only to draw."""

from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from tendond.offline.logs.log import LogError, LogFile
from tendond.offline.logs.metrics import Tracking, runs
from tendond.offline.logs.paths import TipPath
from tendond.offline.plots.appearance import STYLES, appearance
from tendond.offline.plots.figures import run_prefixes
from tendond.offline.plots.output import Named
from tendond.offline.plots.shapes import COLOURS
from tendond.offline.plots.spline import smooth
from tendond.offline.plots.style import DARK, OURS, PAPERS, REFERENCE, gravity_arrow, new_figure, style, title

Array = NDArray[np.float64]

MAX_SHAPES = 25
HEIGHT = 4.6  # [inch], of the planes
MAX_TICKS = 6
TENDON = "#9a9a9a"
MIN_WIDTH = 0.3
"""Minimum width of an axis, as a fraction of the largest extent: a plane viewed edge-on is a strip, not a line."""


def space_figure(log: LogFile, run: Tracking | None = None) -> Figure:
    """Draw rod, tendons, target and the tip's path: three dimensions, the x-z plane, the y-z plane.

    Args:
        log: the log. run: one of its runs; default: all that is in it.
    """
    path = TipPath.of(log, None if run is None else (int(run.ticks[0]), int(run.ticks[-1])))
    low, high = box_limits(path)
    size = high - low
    gravity = np.array(log.config.rod.base_gravity)
    narrow = appearance().sizes.column is not None or appearance().width_mm is not None
    shares = [
        1.5 if narrow else 1.2,
        size[0] / size[2],
        size[1] / size[2],
    ]  # of the figure's height: both planes at the same scale
    with style():
        figure = new_figure(HEIGHT * sum(shares) + 1.6, HEIGHT + 1.1)
        grid = figure.add_gridspec(1, 4, width_ratios=[shares[0], 0.1 if narrow else 0.02, *shares[1:]])
        space: Any = figure.add_subplot(grid[0], projection="3d")
        _draw(space, path, [0, 1, 2])
        space.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
        space.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]")
        for axis, extent in zip((space.xaxis, space.yaxis, space.zaxis), size, strict=True):
            axis.set_major_locator(MaxNLocator(max(1, round((3 if narrow else MAX_TICKS) * extent / size.max()))))
        if narrow:  # labels of three axes have little room
            space.tick_params(labelsize=appearance().points(7))
            for axis in (space.xaxis, space.yaxis, space.zaxis):
                axis.label.set_size(appearance().points(8))
        space.set_box_aspect(size.copy(), zoom=0.8 if narrow else 0.93)
        elevation, azimuth = path.view
        space.view_init(elev=elevation, azim=azimuth)
        gravity_in_space(space, gravity, low, size)
        for index, letter in ((0, "x"), (1, "y")):
            axes = figure.add_subplot(grid[2 + index])
            _draw(axes, path, [index, 2])
            axes.set(xlim=(low[index], high[index]), ylim=(low[2], high[2]), aspect="equal")
            axes.set(xlabel=f"{letter} [mm]", ylabel="z [mm]")
            axes.xaxis.set_major_locator(MaxNLocator(max(2, round(MAX_TICKS * size[index] / size.max()))))
            title(axes, f"{letter}-z plane")
            gravity_arrow(axes, gravity[[index, 2]], 1e3 * path.points[:, [index, 2]])
        handles, labels = space.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
        if len(path.shapes) > 1:
            colours = ScalarMappable(Normalize(0.0, max(1e3 * path.arcs[-1], 1e-9)), COLOURS)
            figure.colorbar(colours, ax=figure.axes, label="distance travelled by the tip [mm]", shrink=0.7, pad=0.01)
    return figure


def space_figures(log: LogFile) -> list[Named]:
    """Return it for each run, or for the log where nothing tracks; nothing where the log has no shape and no tip."""
    if not TipPath.of(log).points.size:
        return []
    try:
        found: list[Tracking | None] = [*runs(log)]
    except LogError:
        found = [None]
    names = run_prefixes(len(found))
    return [Named(f"{prefix}space", partial(space_figure, log, run)) for run, prefix in zip(found, names, strict=True)]


def gravity_in_space(space: Any, gravity: Array, low: Array, size: Array) -> None:
    """Draw an arrow 'g' along gravity, in the upper corner of the box that is farthest from the eye."""
    if (strength := float(np.linalg.norm(gravity))) == 0.0:
        return
    along = 0.2 * size.max() * gravity / strength
    azimuth = np.radians(space.azim)
    far = np.where(np.array([np.cos(azimuth), np.sin(azimuth), -1.0]) > 0.0, 0.1, 0.9)  # opposite to the eye
    tail = low + far * size - 0.5 * along
    space.quiver(*tail, *along, color=DARK, arrow_length_ratio=0.3, lw=1.5)
    space.text(*(tail + 0.5 * along + np.array([0.0, 0.0, 0.05 * size.max()])), "g", color=DARK)


def _draw(axes: Axes, run: TipPath, kept: list[int]) -> None:
    """Draw the components `kept` on axes of two or three dimensions."""

    thick = appearance().sizes.line_width / STYLES["default"].line_width

    def line(points: Array, lw: float = 1.0, **look: Any) -> None:
        axes.plot(*(1e3 * points[:, kept]).T, lw=lw * thick, **look)

    chosen = run.chosen(MAX_SHAPES)
    for i in chosen[:-1]:
        line(run.shapes[i].points, color=_colour(run.arcs[i] / max(run.arcs[-1], 1e-12)), lw=0.9)
    if run.shapes:
        for path in run.shapes[-1].tendons:
            line(smooth(path), color=TENDON, lw=0.8)
        line(run.shapes[-1].points, color="black", lw=2.4, label="rod at the end")
    line(run.reference, color=REFERENCE, lw=3.0, alpha=0.5, label="reference")
    line(run.tip, color=OURS, lw=1.2, label="tip")
    if run.target is not None:
        line(np.array([run.target]), color=PAPERS, ls="", marker="x", ms=9.0 * thick, mew=2.0 * thick, label="target")


def _colour(part: float) -> Any:
    return ScalarMappable(Normalize(0.0, 1.0), COLOURS).to_rgba(np.array([part]))[0]


def box_limits(run: TipPath) -> tuple[Array, Array]:
    """Return lower and upper corner of all that is drawn, with a margin [mm], shapes (3,)."""
    points = 1e3 * run.points
    low, high = points.min(axis=0), points.max(axis=0)
    width = MIN_WIDTH * float((high - low).max())
    lacking = np.maximum(0.0, width - (high - low)) / 2 + 0.04 * float((high - low).max())
    return low - lacking, high + lacking
