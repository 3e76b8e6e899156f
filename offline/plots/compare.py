"""The curves of several runs in one figure. Import this module only to draw."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from tendond.offline.comparison.runs import Compared
from tendond.offline.plots.appearance import WIDE, appearance
from tendond.offline.plots.style import DARK, line_look, new_figure, style, title

SIZE = (12.8, 12.0)  # [inch]
NARROW_SIZE = (12.8, 30.0)
LEGEND_COLUMNS = 4


def overlay(runs: Sequence[Compared]) -> Figure:
    """Draw tip, error, displacement and tension of the agonist, with a curve for each run."""
    with style():
        width = appearance().size(SIZE[0], 1.0)[0]
        columns = 2 if width > 0.5 * WIDE else 1
        figure = new_figure(*(SIZE if columns == 2 else NARROW_SIZE))
        rows = 6 // columns
        grid = list(figure.subplots(rows, columns, sharex=True).flat)
        x, y, z, error, displacement, tension = grid
        for number, one in enumerate(runs):
            run = one.run
            period = float(run.time[1] - run.time[0]) if len(run.time) > 1 else 0.01
            time = (run.ticks - run.ticks[0]) * appearance().unit_of_time(period)
            gaps = np.flatnonzero(np.diff(run.ticks) > 1) + 1
            look = line_look(number, length=len(time))
            tip, reference = 1e3 * run.tip, 1e3 * run.reference
            drawn = [*tip.T, np.linalg.norm(reference - tip, axis=1)]
            drawn += [1e3 * run.displacement[:, run.agonist], run.tension[:, run.agonist]]
            for axes, letter in zip((x, y, z), range(3), strict=True):
                label = "reference" if number == 0 else None
                axes.plot(time, reference[:, letter], color=DARK, lw=0.8, ls=":", label=label)
            for axes, values in zip(grid, drawn, strict=True):
                axes.plot(np.insert(time, gaps, np.nan), np.insert(values, gaps, np.nan), label=one.name, **look)
            for number_of_it, injection in enumerate(run.injections):
                for axes in grid:
                    label = f"injected, {one.name}" if number_of_it == 0 else None
                    axes.axvline(time[injection.start], color=look["color"], lw=0.9, ls=":", label=label)
        labels = {x: "tip x [mm]", y: "tip y [mm]", z: "tip z [mm]", error: "|reference - tip| [mm]",
                  displacement: "displacement [mm]", tension: "tension [N]"}  # fmt: skip
        titles = ("x of the tip", "y of the tip", "z of the tip", "Position error", "Displacement of the agonist",
                  "Tension of the agonist")  # fmt: skip
        for number, ((axes, label), text) in enumerate(zip(labels.items(), titles, strict=True)):
            axes.set_ylabel(label)
            title(axes, text, letter=chr(ord("a") + number))
        for axes in grid[-columns:]:
            axes.set_xlabel(appearance().time_label)
        handles, names = x.get_legend_handles_labels()
        shown = min(len(names), LEGEND_COLUMNS * columns // 2)
        figure.legend(handles, names, loc="outside upper left", ncols=max(1, shown), frameon=False)
    return figure
