"""Tip and force with their bands, forward and smoothed. Import this module only to draw: matplotlib takes a second."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tendond.offline.logs.arrays import Arrays
from tendond.offline.plots.style import OURS, REFERENCE, save, style

Array = NDArray[np.float64]

BAND = 1.96
"""Standard deviations on each side: 95 of 100."""

SHOWN = 1.2
"""Of the smoothed force and its band, range of the axis that shows it: a filter's band at the start is far larger."""


def draw(run: Arrays, out: Path) -> Path:
    """Draw all stretches of a smoothed log, one after the other.

    Raises:
        OSError: the file cannot be written.
    """
    with style():
        figure = Figure((11.0, 7.5), layout="constrained")
        panels = figure.subplots(3, 2, sharex=True)
        for axis, (left, right) in enumerate(panels):
            smooth, forward = run["tip"][:, axis], run["forward.tip"][:, axis]
            spread, wider = run["deviation.tip"][:, axis], run["forward.deviation.tip"][:, axis]
            _both(run, left, 1e3 * np.array([forward - smooth, wider]), 1e3 * np.array([0.0 * smooth, spread]))
            left.set_ylabel(f"{'xyz'[axis]} [mm]")
            smooth, forward = run["force"][:, axis], run["forward.force"][:, axis]
            spread, wider = run["deviation.force"][:, axis], run["forward.deviation.force"][:, axis]
            _both(run, right, np.array([forward, wider]), np.array([smooth, spread]))
            right.set_ylabel(f"{'xyz'[axis]} [N]")
        panels[0, 0].set_title("Tip minus smoothed tip, with 95 % bands")
        panels[0, 1].set_title("Force on the tip, with 95 % bands")
        panels[0, 1].legend(loc="upper left", fontsize=8)
        for axes in panels[-1]:
            axes.set_xlabel("time [s]")
        return save(figure, out)


def _both(run: Arrays, axes: Axes, forward: Array, smooth: Array) -> None:
    """Draw values and standard deviations, shape (2, K) each."""
    for number in np.unique(run["stretch"]):
        part = run["stretch"] == number
        for values, colour, name in ((forward, REFERENCE, "forward"), (smooth, OURS, "smoothed")):
            time, (middle, spread) = run["time"][part], values[:, part]
            axes.fill_between(time, middle - BAND * spread, middle + BAND * spread, color=colour, alpha=0.25, lw=0)
            axes.plot(time, middle, color=colour, lw=1.0, label=name if number == 0 else None)
    low, high = _range(smooth, forward)
    axes.set_ylim(low, high)


def _range(*values: Sequence[Array] | Array) -> tuple[float, float]:
    """Return limits of an axis that hold the smoothed band, and 95 of 100 of the forward values."""
    smooth, forward = values
    edges = np.concatenate((smooth[0] - BAND * smooth[1], smooth[0] + BAND * smooth[1]))
    edges = np.concatenate((edges, np.quantile(forward[0], (0.025, 0.975))))
    middle, half = 0.5 * (edges.max() + edges.min()), 0.5 * SHOWN * (edges.max() - edges.min())
    return float(middle - half), float(middle + half)
