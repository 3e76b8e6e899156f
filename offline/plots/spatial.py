"""A run in space as a figure: in perspective, and from two sides. Import this module only to draw."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from tendond.offline.logs.log import LogFile
from tendond.offline.logs.paths import TipPath
from tendond.offline.plots.spline import smooth
from tendond.offline.plots.style import OURS, PAPERS, REFERENCE, save, style

Array = NDArray[np.float64]

MAX_SHAPES = 25
HEIGHT = 4.6  # [inch], of the planes
MAX_TICKS = 6
TENDON = "#9a9a9a"
MIN_WIDTH = 0.3
"""Minimum width of an axis, as a fraction of the largest extent: a plane viewed edge-on is a strip, not a line."""


def space_figure(log: LogFile) -> Figure:
    """Draw rod, tendons, target and the tip's path: three dimensions, the x-z plane, the y-z plane."""
    run = TipPath.of(log)
    low, high = _limits(run)
    size = high - low
    shares = [1.2, size[0] / size[2], size[1] / size[2]]  # of the figure's height: both planes at the same scale
    with style():
        figure = Figure((HEIGHT * sum(shares) + 1.6, HEIGHT + 1.1), layout="constrained")
        grid = figure.add_gridspec(1, 3, width_ratios=shares)
        space: Any = figure.add_subplot(grid[0], projection="3d")
        _draw(space, run, [0, 1, 2])
        space.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
        space.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]")
        for axis, extent in zip((space.xaxis, space.yaxis, space.zaxis), size, strict=True):
            axis.set_major_locator(MaxNLocator(max(1, round(MAX_TICKS * extent / size.max()))))
        space.set_box_aspect(size, zoom=0.93)
        elevation, azimuth = run.view
        space.view_init(elev=elevation, azim=azimuth)
        for index, letter in ((0, "x"), (1, "y")):
            axes = figure.add_subplot(grid[1 + index])
            _draw(axes, run, [index, 2])
            axes.set(xlim=(low[index], high[index]), ylim=(low[2], high[2]), aspect="equal")
            axes.set(xlabel=f"{letter} [mm]", ylabel="z [mm]", title=f"{letter}-z plane")
        figure.legend(*space.get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
        if len(run.shapes) > 1:
            colours = ScalarMappable(Normalize(0.0, max(1e3 * run.arcs[-1], 1e-9)), "viridis")
            figure.colorbar(colours, ax=figure.axes, label="distance travelled by the tip [mm]", shrink=0.7, pad=0.01)
    return figure


def draw_space(log: LogFile, folder: Path, suffix: str = "png") -> list[Path]:
    """Draw it into `folder`, which is made; nothing where the log has no shape and no tip."""
    if not TipPath.of(log).points.size:
        return []
    folder.mkdir(parents=True, exist_ok=True)
    return [save(space_figure(log), folder / f"space.{suffix}")]


def _draw(axes: Axes, run: TipPath, kept: list[int]) -> None:
    """Draw the components `kept` on axes of two or three dimensions."""

    def line(points: Array, **look: Any) -> None:
        axes.plot(*(1e3 * points[:, kept]).T, **look)

    chosen = run.chosen(MAX_SHAPES)
    for i in chosen[:-1]:
        line(run.shapes[i].points, color=_colour(run.arcs[i] / max(run.arcs[-1], 1e-12)), lw=0.9, alpha=0.8)
    if run.shapes:
        for path in run.shapes[-1].tendons:
            line(smooth(path), color=TENDON, lw=0.8)
        line(run.shapes[-1].points, color="black", lw=2.4, label="rod at the end")
    line(run.tip, color=OURS, lw=1.6, label="tip")
    line(run.reference, color=REFERENCE, lw=1.2, ls="--", label="reference")
    if run.target is not None:
        line(np.array([run.target]), color=PAPERS, ls="", marker="x", ms=9, mew=2, label="target")


def _colour(part: float) -> Any:
    return ScalarMappable(Normalize(0.0, 1.0), "viridis").to_rgba(np.array([part]))[0]


def _limits(run: TipPath) -> tuple[Array, Array]:
    """Return lower and upper corner of all that is drawn, with a margin [mm], shapes (3,)."""
    points = 1e3 * run.points
    low, high = points.min(axis=0), points.max(axis=0)
    width = MIN_WIDTH * float((high - low).max())
    lacking = np.maximum(0.0, width - (high - low)) / 2 + 0.04 * float((high - low).max())
    return low - lacking, high + lacking
