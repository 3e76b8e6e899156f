"""A validation as figures: errors of the models, residuals along the sequence, a hysteresis loop, a residual map.

Import this module only to draw: matplotlib takes a second.
"""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tendond.offline.plots.style import OURS, PAPERS, REFERENCE, save, style
from tendond.offline.validation.evaluate import Validation

Array = NDArray[np.float64]

LOOP = 60
"""Poses on each side of the pose from which a hysteresis loop is drawn."""


def draw(found: Validation, path: Path) -> Path:
    """Draw a validation into a file."""
    with style():
        figure = Figure((10.0, 6.6), layout="constrained")
        (errors, residual), (loop, plane) = figure.subplots(2, 2)
        _draw_errors(found, errors)
        _draw_residuals(found, residual)
        _draw_loop(found, loop)
        _draw_map(found, plane, figure)
        return save(figure, path)


def _draw_errors(found: Validation, axes: Axes) -> None:
    """Draw how many held-out poses each model predicts to within an error."""
    hidden = found.poses.held_out
    for one in found.models:
        distance = np.sort(np.linalg.norm(one.tip[hidden] - found.poses.tip[hidden], axis=1)) * 1e3
        width = 2.0 if one.name.startswith("rod") else 1.0
        axes.semilogx(distance, np.linspace(0.0, 100.0, len(distance)), label=one.name, lw=width)
    axes.set(xlabel="error of the tip [mm]", ylabel="held-out poses [%]", title=f"{found.poses.name}: errors")
    axes.legend(fontsize=7, loc="upper left")


def _draw_residuals(found: Validation, axes: Axes) -> None:
    """Draw the rod's error along the sequence, the held-out parts in colour."""
    distance = np.linalg.norm(found.model("rod").tip - found.poses.tip, axis=1) * 1e3
    number = np.arange(len(distance))
    for part, colour, name in (
        (~found.poses.held_out, REFERENCE, "training"), (found.poses.held_out, PAPERS, "held out"),
    ):  # fmt: skip
        axes.plot(number[part], distance[part], ".", ms=2.0, color=colour, label=name, rasterized=True)
    axes.set(xlabel="pose of the sequence", ylabel="error [mm]", title="rod along the sequence")
    axes.legend(fontsize=8, loc="upper left")


def _draw_loop(found: Validation, axes: Axes) -> None:
    """Draw the tip against the command round a held-out pull that is the furthest, measured and predicted."""
    poses = found.poses
    hidden = np.flatnonzero(poses.held_out)
    tendon = int(np.argmax(np.ptp(poses.command[hidden], axis=0)))
    top = int(hidden[np.argmax(poses.command[hidden, tendon])])
    part = slice(max(0, top - LOOP), min(len(poses), top + LOOP))
    command = poses.command[part, tendon] * 1e3
    along = int(np.argmax(np.ptp(poses.tip[part], axis=0)))
    axes.plot(command, poses.tip[part, along] * 1e3, "k.-", ms=3.0, lw=0.6, label="measured")
    for name, colour in (("rod", OURS), ("rod without friction", PAPERS)):
        axes.plot(command, found.model(name).tip[part, along] * 1e3, color=colour, lw=1.0, label=name)
    title = f"round pose {top}"
    axes.set(xlabel=f"command of tendon {tendon} [mm]", ylabel=f"tip {'xyz'[along]} [mm]", title=title)
    axes.legend(fontsize=8)


def _draw_map(found: Validation, axes: Axes, figure: Figure) -> None:
    """Draw the rod's error where the tips are, over the two axes in which they spread most."""
    tip = found.poses.tip * 1e3
    order = np.argsort(-np.ptp(tip, axis=0))[:2]
    first, second = sorted(int(one) for one in order)
    distance = np.linalg.norm(found.model("rod").tip * 1e3 - tip, axis=1)
    top = float(np.percentile(distance, 98))
    drawn = axes.scatter(tip[:, first], tip[:, second], c=distance, s=3.0, vmin=0.0, vmax=top, rasterized=True)
    axes.set(xlabel=f"tip {'xyz'[first]} [mm]", ylabel=f"{'xyz'[second]} [mm]", title="rod's error [mm]")
    axes.set_aspect("equal")
    figure.colorbar(drawn, ax=axes)
