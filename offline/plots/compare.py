"""Comparison of runs: all metrics, and their curves in one figure. Import this module only to draw."""

import csv
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from tendond.model.rod.static_curve import static_curve
from tendond.model.rods.selection import model_rod
from tendond.offline.files import as_text, whole
from tendond.offline.logs.log import LogFile
from tendond.offline.logs.metrics import Tracking, metrics, tracking
from tendond.offline.plots.style import REFERENCE, style

COLOURS = ("#1f4e79", "#c55a11", "#4b8b3b", "#7b3f98", "#b8860b", "#8c1c13", "#2f8f8f", "#555555")


@dataclass(frozen=True)
class Compared:
    """One run: what to call it, its tracking part, its metrics by name."""

    name: str
    run: Tracking
    metrics: dict[str, Any]


def compared(logs: Sequence[LogFile]) -> list[Compared]:
    """Select each log's first tracking stretch.

    Raises:
        LogError: see `tracking`.
    """
    found = []
    for name, log in zip(_names(logs), logs, strict=True):
        run = tracking(log)
        rod = model_rod(log.config)
        curve = static_curve(rod, log.config.control.agonist, log.config.limits.tension_max, run.axes)
        values = asdict(metrics(run, curve))
        x, y, z = values.pop("final_tip_m")
        found.append(Compared(name, run, {**values, "final_tip_x_m": x, "final_tip_y_m": y, "final_tip_z_m": z}))
    return found


def _names(logs: Sequence[LogFile]) -> list[str]:
    """Return the names of the files, with their folders where needed."""
    stems = [as_text(log.path.stem) for log in logs]
    return stems if len(set(stems)) == len(stems) else [as_text(str(log.path)) for log in logs]


def write_table(runs: Sequence[Compared], path: Path) -> None:
    """Write a CSV file: a line per metric, a column per run; the unit ends a metric's name."""
    with whole(path) as draft, draft.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["metric", *(run.name for run in runs)])
        for name in runs[0].metrics:
            writer.writerow([name, *("" if run.metrics[name] is None else run.metrics[name] for run in runs)])


def overlay(runs: Sequence[Compared]) -> Figure:
    """Draw the paper's four panels with a curve for each run, over time."""
    with style():
        figure = Figure((12.8, 8.0), layout="constrained")
        bend, along, displacement, error = figure.subplots(2, 2).flat
        for i, one in enumerate(runs):
            run, colour = one.run, COLOURS[i % len(COLOURS)]
            tip, reference = 1000.0 * run.tip, 1000.0 * run.reference
            bend.plot(run.time, reference[:, run.axis], color=REFERENCE, lw=1.0, ls="--")
            bend.plot(run.time, tip[:, run.axis], color=colour, label=one.name)
            along.plot(run.time, tip[:, 2], color=colour)
            displacement.plot(run.time, 1000.0 * run.displacement[:, run.agonist], color=colour)
            error.plot(run.time, np.linalg.norm(reference - tip, axis=1), color=colour)
        letters = "/".join(sorted({"xyz"[one.run.axis] for one in runs}))
        bend.set(title=f"{letters} of the tip, and its reference", ylabel=f"tip {letters} [mm]")
        along.set(title="z of the tip", ylabel="tip z [mm]")
        displacement.set(title="Tendon displacement", ylabel="displacement [mm]", xlabel="time [s]")
        error.set(title="Position error", ylabel="|reference - tip| [mm]", xlabel="time [s]")
        bend.legend(fontsize=9)
    return figure
