"""Figures of a log's runs: overview, shapes, and each panel alone. Import only to draw: needs the extra `plot`."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tendond.offline.logs.log import LogFile
from tendond.offline.logs.metrics import Tracking, runs
from tendond.offline.logs.published import Published
from tendond.offline.plots.appearance import WIDE, appearance
from tendond.offline.plots.output import Named, Output
from tendond.offline.plots.panels import Panels
from tendond.offline.plots.shapes import draw_shapes
from tendond.offline.plots.style import headline, new_figure, style, title

SIZE = (6.4, 4.0)  # [inch]
SHAPES_SIZE = (6.4, 4.6)
OVERVIEW_ROW = 3.3

NAMES = ("overview", "shapes")
"""Figures of a run."""

PANELS = ("tip_x", "tip_y", "tip_z", "error", "tension", "displacement", "tip_speed", "tendon_speed")
"""Parts of the overview, which may be figures of their own as well."""


def run_prefixes(count: int) -> list[str]:
    """Return what begins the names of the figures of each of `count` runs: nothing of a single one."""
    return [""] if count == 1 else [f"run{number}-" for number in range(1, count + 1)]


def draw(
    log: LogFile, output: Output | Path, published: Published | None = None, *, panels: bool = False
) -> list[Path]:
    """Draw each run of a log, see `run_figures`, and return the files.

    Raises:
        LogError: nothing tracks. DaemonError: a file exists already.
    """
    output = Output(output) if isinstance(output, Path) else output
    return output.draw(run_figures(log, published, panels=panels))


def run_figures(log: LogFile, published: Published | None = None, *, panels: bool = False) -> list[Named]:
    """Return the figures of each run of a log: the overview and the shapes.

    Args:
        log: the log.
        published: a paper's figures of the first run.
        panels: each panel of the overview as a figure of its own as well.

    Raises:
        LogError: nothing tracks.
    """
    figures: list[Named] = []
    found = runs(log)
    for number, (run, prefix) in enumerate(zip(found, run_prefixes(len(found)), strict=True), 1):
        drawn = Panels(log, run, published if number == 1 else None)
        for name, panel in drawn.all.items() if panels else ():
            figures.append(Named(prefix + name, partial(_alone, panel)))
        what = f"{log.name}{f', run {number}' if prefix else ''}"
        figures.append(Named(f"{prefix}overview", partial(_overview, drawn, log, what)))
        figures.append(Named(f"{prefix}shapes", partial(_shapes, log, run)))
    return figures


def _alone(panel: Callable[[Axes], None]) -> Figure:
    figure = new_figure(*SIZE)
    panel(figure.subplots())
    return figure


def overview(log: LogFile, published: Published | None = None) -> Figure:
    """Draw the panels of the first run in one figure; raises LogError, see `runs`."""
    with style():
        return _overview(Panels(log, runs(log)[0], published), log, log.name)


def shapes_figure(log: LogFile) -> Figure:
    """Draw the rod's shapes in the first run; raises LogError, see `runs`."""
    with style():
        return _shapes(log, runs(log)[0])


def _shapes(log: LogFile, run: Tracking) -> Figure:
    figure = new_figure(*SHAPES_SIZE)
    draw_shapes(figure.subplots(), log, run)
    return figure


def _overview(panels: Panels, log: LogFile, name: str) -> Figure:
    drawn = panels.all
    width = appearance().size(2 * SIZE[0], 1.0)[0]
    columns = 2 if width > 0.5 * WIDE else 1
    rows = -(-len(drawn) // columns)
    figure = new_figure(2 * SIZE[0], OVERVIEW_ROW * rows * (2.0 / columns))
    grid = figure.subplots(rows, columns, sharex=True)
    for number, (axes, panel) in enumerate(zip(grid.flat, drawn.values(), strict=True)):
        panels.names_injections = number == 0
        panel(axes)
        if not appearance().sizes.titles:
            title(axes, "", letter=chr(ord("a") + number))
        if number < len(drawn) - columns:
            axes.set_xlabel("")
    headline(figure, f"{name}: {log.config.control.law.replace('_', ' ')}")
    return figure
