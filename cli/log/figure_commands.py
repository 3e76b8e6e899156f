"""Options and help of `tendond log plot`, `log compare` and `log animate`."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.completion import logs
from tendond.cli.figure_options import (
    FigureStyle,
    Font,
    Force,
    Formats,
    Iterations,
    PageFormats,
    Width,
    appearance_of,
)
from tendond.cli.options import Json

LogFile = Annotated[
    Path,
    typer.Argument(metavar="LOG", help="MCAP file of 'tendond run'; any part of a split log.", autocompletion=logs),
]
LogFiles = Annotated[
    list[Path], typer.Argument(metavar="LOG...", help="MCAP files of 'tendond run'.", autocompletion=logs)
]


def plot(
    file: LogFile,
    out: Annotated[Path | None, typer.Option("--out", help="Folder for the figures. Default: LOG-plots.")] = None,
    format: PageFormats = "png",
    style: FigureStyle = "default",
    width: Width = None,
    font: Font = None,
    iterations: Iterations = False,
    panels: Annotated[
        bool, typer.Option("--panels", help="Each panel of the overview as a figure of its own as well.")
    ] = False,
    force: Force = False,
) -> None:
    """Plot all runs of a log.

    An overview of tip, error, tensions, displacements and speeds; rod shapes, the run in space, loop timing, modes and
    faults. Each run, from arming on, has figures of its own; their names begin with the log's. Files that exist are
    not overwritten.

    Example: tendond plot run.mcap --panels --format pdf,svg --style ieee
    """
    from tendond.cli.log.figures import PAGE, run_plot
    from tendond.offline.plots.appearance import parse_formats

    formats = parse_formats(format, (PAGE,))
    drawn = tuple(one for one in formats if one != PAGE)
    run_plot(
        file,
        out,
        appearance_of(drawn, style, width, font, iterations=iterations),
        page=PAGE in formats,
        panels=panels,
        force=force,
    )


def compare(
    files: LogFiles,
    out: Annotated[
        Path | None,
        typer.Option("--out", help="Folder for table and figure. Default: out/compare, out/compare-2, ..."),
    ] = None,
    table: Annotated[
        str | None,
        typer.Option("--table", metavar="FORMAT", help="Print and write it as csv, markdown or latex (booktabs)."),
    ] = None,
    repeats: Annotated[
        bool,
        typer.Option("--repeats", help="Mean and 95 % confidence interval of runs that differ in nothing but seeds."),
    ] = False,
    format: Formats = "png",
    style: FigureStyle = "default",
    width: Width = None,
    font: Font = None,
    iterations: Iterations = False,
    force: Force = False,
    json: Json = False,
) -> None:
    """Compare runs.

    A table of all metrics with their units, and the curves in one figure; all runs of each log. Logs of the same name
    are told apart by their folders. Files that exist are not overwritten.

    Example: tendond log compare backstepping.mcap sliding_mode.mcap --table latex --format pdf
    """
    from tendond.cli.log.figures import run_compare
    from tendond.offline.plots.appearance import parse_formats

    if table not in (None, "csv", "markdown", "latex"):
        raise typer.BadParameter(f"'{table}': choose csv, markdown or latex", param_hint="--table")
    look = appearance_of(parse_formats(format), style, width, font, iterations=iterations)
    run_compare(files, out, look, table, repeats=repeats, as_json=json, force=force)


def animate(
    file: LogFile,
    out: Annotated[
        Path | None, typer.Option("--out", help="File to write, .gif, .mp4 or .apng. Default: LOG, LOG-run2, ... .gif.")
    ] = None,
    format: Annotated[
        str, typer.Option("--format", metavar="LIST", help="Without --out: one or several of gif, mp4 and apng.")
    ] = "gif",
    run: Annotated[int, typer.Option("--run", min=1, help="Number of the run in the log.")] = 1,
    first: Annotated[float, typer.Option("--from", min=0.0, help="First time, from the run's start on [s].")] = 0.0,
    last: Annotated[float, typer.Option("--to", help="Last time [s].")] = float("inf"),
    speed: Annotated[
        float, typer.Option("--speed", min=0.01, max=100.0, help="Speed: 0.25 shows a second in four.")
    ] = 1.0,
    rate: Annotated[int, typer.Option("--fps", min=1, max=100, help="Pictures a second.")] = 20,
    width: Annotated[int, typer.Option("--width", min=200, max=4000, help="Width of the picture [pixels].")] = 900,
    force: Force = False,
) -> None:
    """Animate a run: the rod with target, forces and traces.

    GIF and APNG need Pillow, which comes with matplotlib; MP4 needs ffmpeg. Files that exist are not overwritten.

    Example: tendond animate run.mcap --speed 0.25 --to 1.5 --out run.mp4
    """
    from tendond.cli.log.animate import run_animate
    from tendond.offline.plots.appearance import MOVIES, parse_formats

    if out is not None and out.suffix.lstrip(".").lower() not in MOVIES:
        raise typer.BadParameter(f"'{out}': end its name in .{', .'.join(MOVIES)}", param_hint="--out")
    if last <= first:
        raise typer.BadParameter(f"{last:g}: must be later than --from {first:g}", param_hint="--to")
    forms = parse_formats(format, allowed=MOVIES) if out is None else (out.suffix.lstrip(".").lower(),)
    run_animate(file, out, forms, run, (first, last), speed, rate, width, force=force)
