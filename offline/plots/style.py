"""Style of figures: colours, levels, notes. Import this module only to draw: matplotlib takes a second."""

from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import OffsetFrom
from numpy.typing import NDArray

from tendond.offline.files import whole

OURS, REFERENCE, PAPERS = "#1f4e79", "#7f7f7f", "#c55a11"

ARROW_POINTS = 40.0
"""Length of the arrow of gravity, in points of the figure."""


def level(axes: Axes, value: float, text: str, colour: str = REFERENCE, *, below: bool = False) -> None:
    """Draw a light horizontal line with a label at the right."""
    axes.axhline(value, color=colour, lw=0.8)
    axes.annotate(
        text,
        (1.0, value),
        (-2, -3 if below else 3),
        xycoords=axes.get_yaxis_transform(),
        textcoords="offset points",
        ha="right",
        va="top" if below else "bottom",
        color=colour,
        fontsize=9,
    )


def note(axes: Axes, point: tuple[float, float], text: str, colour: str, offset: tuple[int, int]) -> None:
    axes.annotate(text, point, offset, textcoords="offset points", color=colour, fontsize=9)


def gravity_arrow(axes: Axes, gravity: NDArray[np.float64]) -> None:
    """Draw an arrow 'g' in the upper right corner, along gravity.

    Args:
        axes: axes with the same scale in both directions.
        gravity: [m/s^2], its components along the axes, shape (2,). If they vanish, nothing is drawn.
    """
    size = float(np.hypot(*gravity))
    if size == 0.0:
        return
    tail = (0.9, 0.93)  # of the axes
    along = ARROW_POINTS * gravity / size
    axes.annotate(
        "",
        xy=tuple(along),
        xytext=tail,
        xycoords=OffsetFrom(axes, tail, "points"),
        textcoords="axes fraction",
        arrowprops={"arrowstyle": "->", "color": REFERENCE, "lw": 1.5},
    )
    axes.annotate("g", tail, (5, -4), xycoords="axes fraction", textcoords="offset points", color=REFERENCE)


def style() -> AbstractContextManager[None]:
    return rc_context(
        {
            "axes.grid": True,
            "axes.spines.right": False,
            "axes.spines.top": False,
            "axes.titlelocation": "left",
            "axes.titlesize": 11,
            "figure.constrained_layout.h_pad": 0.1,
            "figure.constrained_layout.w_pad": 0.1,
            "font.size": 10,
            "grid.alpha": 0.25,
            "lines.linewidth": 1.8,
            "savefig.dpi": 150,
        }
    )


def save(figure: Figure, path: Path) -> Path:
    with whole(path) as draft:
        figure.savefig(draft)
    return path
