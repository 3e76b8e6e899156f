"""Appearance of figures: sizes and fonts of a style, formats, axis of time. Imports no matplotlib, which takes long."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field

from tendond.daemon.errors import UsageError

FORMATS = ("png", "pdf", "svg")

MOVIES = ("gif", "mp4", "apng")
"""Formats of an animation."""

MM = 1.0 / 25.4
"""A millimetre in inches, the unit of matplotlib."""

WIDE = 9.0
"""Width from which on a figure of the default style takes both columns of a page [inch]."""

MIN_LINES = 18.0
"""Smallest height of a figure, in sizes of its font: labels and a legend of six lines take ten."""

SERIF = ("Times New Roman", "Times", "Nimbus Roman", "Liberation Serif", "STIXGeneral")
SANS = ("Arial", "Helvetica", "Nimbus Sans", "Liberation Sans", "DejaVu Sans")


@dataclass(frozen=True)
class Style:
    """Sizes and fonts that a publisher asks for, or a projector.

    Attributes:
        column, page: widths of a figure in one column and across the page [inch]; none: as drawn.
        font_size: of labels [points]. fonts: names in the order of preference; none: matplotlib's.
        line_width: of a curve [points].
        titles: figures have titles; not in a paper, where the caption says it.
        height: factor on the height of a narrower figure, so that its larger text has room.
    """

    column: float | None = None
    page: float | None = None
    font_size: float = 10.0
    fonts: tuple[str, ...] = ()
    line_width: float = 1.8
    titles: bool = True
    height: float = 1.0


STYLES = {
    "default": Style(),
    "ieee": Style(88.9 * MM, 182.0 * MM, 8.0, SERIF, 1.0, False, 1.2),
    "elsevier": Style(90.0 * MM, 190.0 * MM, 7.0, SANS, 1.0, False, 1.15),
    "slides": Style(200.0 * MM, 310.0 * MM, 16.0, SANS, 2.6, True, 1.1),
}
"""Styles by name. Widths: IEEE 3.5 and 7.16 inch (Preparation of Papers for IEEE Journals), 8 pt; Elsevier 90 and
190 mm, 7 pt (Artwork sizing); slides of 16:9 are 339 mm wide."""


@dataclass(frozen=True)
class Appearance:
    """How figures are drawn and saved.

    Attributes:
        style: name of a style, see `STYLES`.
        formats: endings of the files, of `FORMATS`.
        width_mm: width of every figure instead of the style's [mm].
        font: name of the font instead of the style's.
        iterations: the axis of time counts cycles; else it is in seconds.
    """

    style: str = "default"
    formats: tuple[str, ...] = ("png",)
    width_mm: float | None = None
    font: str | None = None
    iterations: bool = False
    sizes: Style = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "sizes", STYLES[self.style])

    def size(self, width: float, height: float) -> tuple[float, float]:
        """Return the size of a figure that the default style draws with this one [inch]."""
        wanted = self.sizes.page if width >= WIDE else self.sizes.column
        if self.width_mm is not None:
            wanted = self.width_mm * MM
        if wanted is None:
            return width, height
        room = self.sizes.height if wanted < width else 1.0
        return wanted, max(height * wanted / width * room, MIN_LINES * self.sizes.font_size / 72.0)

    def points(self, size: float) -> float:
        """Scale a size of the default style to this one [points]."""
        return size * self.sizes.font_size / STYLES["default"].font_size

    @property
    def time_label(self) -> str:
        """Label of the axis of time."""
        return "iteration" if self.iterations else "time [s]"

    def unit_of_time(self, period: float) -> float:
        """Return what a cycle of `period` [s] takes on the axis of time."""
        return 1.0 if self.iterations else period


def parse_formats(text: str, more: Sequence[str] = (), allowed: Sequence[str] = FORMATS) -> tuple[str, ...]:
    """Read the formats of `--format pdf,svg`.

    Args:
        text: as given. more: allowed beside `allowed`.

    Raises:
        UsageError: one is unknown.
    """
    choice = (*allowed, *more)
    found = tuple(dict.fromkeys(name.strip().lower() for name in text.split(",") if name.strip()))
    wrong = [name for name in found if name not in choice]
    if wrong or not found:
        raise UsageError(f"--format: '{(wrong or [text])[0]}': choose one or several of {', '.join(choice)}")
    return found


_APPEARANCE: ContextVar[Appearance | None] = ContextVar("appearance", default=None)


def appearance() -> Appearance:
    """Return the appearance in use."""
    return _APPEARANCE.get() or Appearance()


@contextmanager
def appearing(chosen: Appearance) -> Iterator[None]:
    """Use an appearance for all figures that are drawn and saved meanwhile."""
    token = _APPEARANCE.set(chosen)
    try:
        yield
    finally:
        _APPEARANCE.reset(token)
