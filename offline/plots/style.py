"""Style of figures: colours, lines, levels, notes. Import this module only to draw: matplotlib takes a second."""

import logging
from contextlib import AbstractContextManager
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import font_manager, rc_context, rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.text import OffsetFrom
from matplotlib.textpath import text_to_path
from numpy.typing import NDArray

from tendond.daemon.errors import UsageError
from tendond.offline.files import whole
from tendond.offline.plots.appearance import appearance

logging.getLogger("fontTools").setLevel(logging.ERROR)  # it tells of every table of a font that a PDF takes up

OURS, REFERENCE, PAPERS, DARK = "#1f4e79", "#7f7f7f", "#c55a11", "#404040"

LINES: tuple[tuple[str, Any, str], ...] = (
    ("#14335c", "-", "o"),
    ("#c8501e", (0, (5, 1.5)), "s"),
    ("#3fa37c", (0, (5, 1.5, 1, 1.5)), "^"),
    ("#eebf45", (0, (1.5, 1)), "D"),
    ("#6d2c7f", (0, (8, 2)), "v"),
    ("#7fb0de", (0, (3, 1, 1, 1, 1, 1)), "P"),
    ("#8c1c13", (0, (8, 2, 2, 2)), "X"),
    ("#9a9a9a", (0, (2, 2)), "<"),
)
"""Colour, dashes and marker of each curve in a figure: neighbours differ in luminance, for prints in grey."""

MARKED = 9
"""Markers on a curve."""

ARROW_POINTS = 40.0
"""Length of the arrow of gravity, in points of the default style's figure."""


def line_look(number: int, *, length: int, plain: bool = False) -> dict[str, Any]:
    """Return colour, dashes and markers of curve `number` in a figure, for `Axes.plot`.

    Args:
        number: from 0 on; after the last of `LINES` they begin again.
        length: points of the curve, on which the markers are spread.
        plain: without markers, for curves that differ by what they are rather than by their order.
    """
    colour, dashes, marker = LINES[number % len(LINES)]
    look: dict[str, Any] = {"color": colour, "ls": dashes}
    if not plain:
        every = max(1, length // MARKED)
        look |= {"marker": marker, "ms": appearance().points(4.0), "markevery": (number * every // 4 % every, every)}
    return look


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
        fontsize=appearance().points(9),
    )


def note(axes: Axes, point: tuple[float, float], text: str, colour: str, offset: tuple[int, int]) -> None:
    axes.annotate(text, point, offset, textcoords="offset points", color=colour, fontsize=appearance().points(9))


def title(axes: Axes, text: str, *, letter: str = "") -> None:
    """Title a panel; in the style of a paper, whose caption says what it is, with its letter alone."""
    if appearance().sizes.titles:
        axes.set_title(text)
    elif letter:
        axes.annotate(
            f"({letter})", (0.0, 1.0), (-4, 3), xycoords="axes fraction", textcoords="offset points", ha="right"
        )


def headline(figure: Figure, text: str) -> None:
    """Title a figure; not in the style of a paper."""
    if appearance().sizes.titles:
        figure.suptitle(text, x=0.01, ha="left", fontsize=appearance().points(12))


def legend_above(axes: Axes, share: float = 1.0) -> None:
    """Name the curves above the axes, where no curve can be; nothing where none has a name.

    Args:
        axes: the axes.
        share: of the place of a panel that they have, beside a colour bar.
    """
    handles, labels = axes.get_legend_handles_labels()
    if not handles:
        return
    size = appearance().points(9)
    room = 72.0 * share * _figure_width(axes) / _columns_of_panels(axes) - 6.5 * size  # less what the axis takes
    columns = next((n for n in range(len(labels), 1, -1) if _width(labels, n, size) <= room), 1)
    rows = -(-len(labels) // columns)
    axes.legend(
        handles,
        labels,
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=columns,
        frameon=False,
        fontsize=size,
        borderaxespad=0.2,
        borderpad=0.1,
        labelspacing=0.25,
        columnspacing=1.2,
        handlelength=2.2,
    )
    if axes.get_title(loc="left"):
        axes.set_title(axes.get_title(loc="left"), pad=6.0 + 1.35 * size * rows)


def _width(labels: list[str], columns: int, size: float) -> float:
    """Return the width of a legend with so many columns, as matplotlib fills them [points]."""
    parts = np.array_split(labels, columns)
    return sum(max(_text_width(label, size) for label in part) + 4.2 * size for part in parts)


def _text_width(text: str, size: float) -> float:
    """Return the width of a text in the font in use [points]."""
    return float(text_to_path.get_text_width_height_descent(text, FontProperties(size=size), "$" in text)[0])


def _figure_width(axes: Axes) -> float:
    """Return the width of the figure of these axes [inch]."""
    figure = axes.get_figure(root=True)
    return 0.0 if figure is None else float(figure.get_size_inches()[0])


def _columns_of_panels(axes: Axes) -> float:
    """Return how many such axes are beside each other."""
    place = axes.get_subplotspec()
    return 1.0 if place is None else place.get_gridspec().ncols / len(place.colspan)


def gravity_arrow(axes: Axes, gravity: NDArray[np.float64], drawn: NDArray[np.float64] | None = None) -> None:
    """Draw an arrow 'g' along gravity, in the corner of the axes where the fewest points are.

    Args:
        axes: axes with the same scale in both directions.
        gravity: [m/s^2], its components along the axes, shape (2,). If they vanish, nothing is drawn.
        drawn: points that are in the figure, in data coordinates, shape (n, 2).
    """
    size = float(np.hypot(*gravity))
    if size == 0.0:
        return
    centre = _emptiest(drawn)
    room = _figure_width(axes) / max(1.0, _columns_of_panels(axes) - 1.0)  # a column is a colour bar or a gap
    along = ARROW_POINTS * gravity / size * min(1.0, room / 6.4)
    axes.annotate(
        "",
        xy=tuple(0.5 * along),
        xytext=tuple(-0.5 * along),
        xycoords=OffsetFrom(axes, centre, "points"),
        textcoords=OffsetFrom(axes, centre, "points"),
        arrowprops={"arrowstyle": "->", "color": DARK, "lw": 0.8 * appearance().sizes.line_width, "shrinkA": 0},
    )
    aside = 0.9 * appearance().sizes.font_size * np.array([abs(gravity[1]), abs(gravity[0])]) / size
    axes.annotate("g", centre, tuple(aside), xycoords="axes fraction", textcoords="offset points", color=DARK,
                  ha="center", va="center")  # fmt: skip


def _emptiest(drawn: NDArray[np.float64] | None) -> tuple[float, float]:
    """Return the corner with the fewest points about it, in fractions of the axes; the upper right one of equals."""
    corners = ((0.9, 0.85), (0.1, 0.85), (0.9, 0.15), (0.1, 0.15))
    if drawn is None or not drawn.size:
        return corners[0]
    low, high = np.nanmin(drawn, axis=0), np.nanmax(drawn, axis=0)
    places = (drawn - low) / np.maximum(high - low, 1e-12)
    return min(corners, key=lambda corner: int((np.abs(places - corner) < 0.16).all(axis=1).sum()))


def style(*, text_as_text: bool = True) -> AbstractContextManager[None]:
    """Return matplotlib's settings of the appearance in use.

    Raises:
        UsageError: its font is not installed.
    """
    look = appearance()
    sizes = look.sizes
    fonts = _installed(look.font, sizes.fonts)
    return rc_context(
        {
            "axes.grid": True,
            "axes.linewidth": 0.08 * sizes.font_size,
            "axes.spines.right": False,
            "axes.spines.top": False,
            "axes.titlelocation": "left",
            "axes.titlesize": look.points(11),
            "figure.constrained_layout.h_pad": 0.1 if sizes.titles else 0.04,
            "figure.constrained_layout.w_pad": 0.1 if sizes.titles else 0.04,
            **({"font.family": fonts} if fonts else {}),
            "font.size": sizes.font_size,
            "grid.alpha": 0.25,
            "lines.linewidth": sizes.line_width,
            "mathtext.fontset": "stix" if sizes.fonts[:1] == ("Times New Roman",) else "dejavusans",
            "pdf.fonttype": 42,  # TrueType: publishers refuse Type 3
            "savefig.dpi": 150 if sizes.titles else 300,
            "svg.fonttype": "none" if text_as_text else "path",
        }
    )


@lru_cache(maxsize=8)
def _installed(font: str | None, fonts: tuple[str, ...]) -> list[str]:
    """Select the installed ones of a style's fonts, or check the one that is wanted."""
    known = set(font_manager.get_font_names())
    if font is None:
        return [name for name in fonts if name in known]
    if font not in known:
        near = [name for name in sorted(known) if name.lower()[:4] == font.lower()[:4]] or sorted(known)
        raise UsageError(f"--font: '{font}' is not installed here; there are {', '.join(near[:12])}")
    return [font]


def new_figure(width: float, height: float) -> Figure:
    """Make a figure that has this size [inch] in the default style, and the style's width otherwise."""
    return Figure(appearance().size(width, height), layout="constrained")


def save(figure: Figure, path: Path) -> Path:
    """Save a figure in each format of the appearance in use, beside `path`; return the first file."""
    paths = [path.with_name(f"{path.stem}.{form}") for form in appearance().formats]
    with style():
        place_parts(figure)
        for one in paths:
            write(figure, one)
    return paths[0]


def write(figure: Figure, path: Path) -> None:
    """Write a figure whose parts are placed, in the format of the file's ending.

    A PNG is compressed quickly: that takes a fifth of the time that drawing a run takes, and a third more bytes.
    """
    quickly: dict[str, Any] = {"pil_kwargs": {"compress_level": 1}} if path.suffix == ".png" else {}
    with whole(path) as draft:
        figure.savefig(draft, **quickly)


def place_parts(figure: Figure) -> None:
    """Run a figure's layout, and end it: saving a figure that has one draws it twice, once only for its layout."""
    layout = figure.get_layout_engine()
    if layout is not None and figure.axes:
        if isinstance(resolution := rcParams["savefig.dpi"], float):  # or "figure": as it is
            figure.set_dpi(resolution)
        layout.execute(figure)
        figure.set_layout_engine(None)
