"""The paper's figures of the rod: configurations during the motion, and snapshots. Import this module only to draw.

z runs to the right and x upwards: so gravity, which acts along -x, pulls down.
"""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from tendond.offline.paper.figures import COLOURS, DARK, Named, name_of, pushes_of, unit_of
from tendond.offline.paper.run import PaperRun, Runs
from tendond.offline.paper.scenarios import start_of
from tendond.offline.plots.appearance import appearance
from tendond.offline.plots.shapes import COLOURS as SHADES
from tendond.offline.plots.style import REFERENCE, gravity_arrow, headline, new_figure, note, save, style

EVERY = 5
"""Iterations between two configurations, as in the paper."""

SHOWN = 60
SNAPSHOTS = (0, 3, 6, 10, 20, 60)
"""Iterations whose shapes are drawn."""

AFTER_IMPACT = 1
"""Iterations after the end of an impact at which its snapshot is taken."""

FRAME = ((-340.0, 560.0), (-430.0, 560.0))
"""Ranges of z and x [mm]."""

ARROW = 15.0
"""Length of an arrow by the force [mm/N]."""


def configurations(scenario: str, title: str, runs: Runs, path: Path) -> Path:
    """Draw the rod every five iterations, a panel per law."""
    with style():
        figure = new_figure(10.0, 4.1)
        panels = figure.subplots(1, 2, sharex=True, sharey=True)
        unit = unit_of(runs[scenario, next(iter(COLOURS))])
        colours = ScalarMappable(Normalize(0.0, unit * SHOWN), SHADES)
        for axes, law in zip(panels, COLOURS, strict=True):
            run = runs[scenario, law]
            for i in range(0, min(SHOWN + 1, len(run.shapes)), EVERY):
                points = 1e3 * run.shapes[i]
                axes.plot(points[:, 2], points[:, 0], color=colours.cmap(i / SHOWN), lw=1.4)
            axes.plot(1e3 * run.tip[: SHOWN + 1, 2], 1e3 * run.tip[: SHOWN + 1, 0], ":", color=DARK, lw=1.0)
            target = 1e3 * run.target
            axes.plot(target[2], target[0], "x", color="#b2182b", ms=9, mew=2)
            note(axes, (target[2], target[0]), "target", "#b2182b", (-16, -16))
            axes.set(xlabel="z [mm]", title=name_of(law), aspect="equal")
            gravity_arrow(axes, np.array(run.scenario.config.rod.base_gravity)[[2, 0]])
        panels[0].set_ylabel("x [mm]")
        figure.colorbar(colours, ax=list(panels), label=appearance().time_label, shrink=0.8)
        headline(figure, f"{title}: the rod every {EVERY} iterations; dotted: path of the tip")
        return save(figure, path)


def snapshots(scenarios: Named, law: str, runs: Runs, path: Path) -> Path:
    """Draw the rod at some iterations, a row per scenario, with hanging weights and impacts."""
    with style():
        columns = len(SNAPSHOTS)
        figure = new_figure(1.75 * columns, 2.15 * len(scenarios) + 0.5)
        rows = figure.subplots(len(scenarios), columns, sharex=True, sharey=True)
        for row, (scenario, title) in zip(rows, scenarios, strict=True):
            run = runs[scenario, law]
            pushes = pushes_of(run)
            moments = _moments(run)[:columns] if pushes else list(SNAPSHOTS)
            for axes, i in zip(row, moments, strict=True):
                _snapshot(axes, run, i)
                axes.set_title(_moment(i, unit_of(run)), fontsize=appearance().points(8))
            row[0].set_ylabel(f"{title}\nx [mm]", fontsize=appearance().points(9))
        for axes in rows[-1]:
            axes.set_xlabel("z [mm]", fontsize=appearance().points(9))
        rows[0][0].set(xlim=FRAME[0], ylim=FRAME[1])
        headline(figure, f"{name_of(law)} on a rig-like plant")
        return save(figure, path)


def _moment(iteration: int, unit: float) -> str:
    return f"iteration {iteration}" if appearance().iterations else f"{unit * iteration:.2f} s"


def _moments(run: PaperRun) -> list[int]:
    """Iterations just after each impact."""
    config = run.scenario.config
    ends = [impact.time + impact.duration for impact in config.simulator.impacts]
    return [round(end / config.loop.period) - start_of(config) + AFTER_IMPACT for end in ends]


def _snapshot(axes: Axes, run: PaperRun, i: int) -> None:
    config = run.scenario.config
    points = 1e3 * run.shapes[i]
    target = 1e3 * run.target
    axes.plot(target[2], target[0], "x", color=REFERENCE, ms=6, mew=1.5)
    axes.plot(points[:, 2], points[:, 0], color=COLOURS[run.law], lw=2.2)
    axes.plot(points[0, 2], points[0, 0], "s", color=DARK, ms=5)
    weight = config.simulator.weight
    force = run.tip_force[i]
    if weight.mass > 0.0 and np.linalg.norm(force) > 0.0:
        end = points[-1] + 1e3 * weight.string * force / np.linalg.norm(force)
        axes.plot([points[-1, 2], end[2]], [points[-1, 0], end[0]], color=REFERENCE, lw=0.8)
        axes.plot(end[2], end[0], "o", color=DARK, ms=3.0 + 60.0 * weight.mass)
    for impact in config.simulator.impacts:
        over = i - (round((impact.time + impact.duration) / config.loop.period) - start_of(config))
        if over == AFTER_IMPACT:
            at = points[round(impact.place * (len(points) - 1))]
            push = ARROW * np.array(impact.force)
            axes.annotate(
                "",
                (at[2], at[0]),
                (at[2] - push[2], at[0] - push[0]),
                arrowprops={"arrowstyle": "-|>", "color": "#b2182b", "lw": 1.5, "shrinkA": 0, "shrinkB": 0},
                annotation_clip=False,
            )
    axes.set_aspect("equal")
    axes.tick_params(labelsize=appearance().points(7))
