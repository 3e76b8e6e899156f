"""How figures look: colours, levels, notes. Import this module only to draw: matplotlib takes a second."""

from contextlib import AbstractContextManager
from pathlib import Path

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

OURS, REFERENCE, PAPERS = "#1f4e79", "#7f7f7f", "#c55a11"


def level(axes: Axes, value: float, text: str, colour: str = REFERENCE, *, below: bool = False) -> None:
    """A light line across, with its meaning written on it at the right."""
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
    figure.savefig(path)
    return path
