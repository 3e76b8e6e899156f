"""Options of the commands that draw figures."""

from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from tendond.offline.plots.appearance import Appearance


def styles() -> list[str]:
    """Return the names of the styles, for the shell's completion."""
    from tendond.offline.plots.appearance import STYLES

    return list(STYLES)


Formats = Annotated[str, typer.Option("--format", metavar="LIST", help="One or several of png, pdf and svg: pdf,svg.")]
PageFormats = Annotated[
    str,
    typer.Option(
        "--format", metavar="LIST", help="One or several of png, pdf, svg, and html for an interactive page: pdf,svg."
    ),
]
FigureStyle = Annotated[
    str,
    typer.Option(
        "--style",
        help="Widths and fonts of figures: default, ieee (89 or 182 mm), elsevier (90 or 190 mm), or slides.",
        autocompletion=styles,
    ),
]
Width = Annotated[
    float | None, typer.Option("--width", min=20.0, max=2000.0, help="Width of each figure [mm]. Default: the style's.")
]
Font = Annotated[str | None, typer.Option("--font", help="Font of all text. Default: the style's.")]
Iterations = Annotated[bool, typer.Option("--iterations", help="Count cycles on the axis of time, not seconds.")]
Force = Annotated[bool, typer.Option("--force", help="Replace files that exist; else nothing is overwritten.")]


def appearance_of(
    formats: tuple[str, ...], style: str, width: float | None, font: str | None, *, iterations: bool
) -> "Appearance":
    """Return the appearance that the options describe.

    Raises:
        BadParameter: there is no such style.
    """
    from tendond.offline.plots.appearance import STYLES, Appearance
    from tendond.schemas.errors.explain import choose

    if style not in STYLES:
        raise typer.BadParameter(f"'{style}': {choose(style, STYLES)}", param_hint="--style")
    return Appearance(style, formats, width, font, iterations)
