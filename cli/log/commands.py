"""The commands that take a log: their options and their help; what they do stands in the modules that they import."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.options import Json, laws

LogFile = Annotated[Path, typer.Argument(metavar="LOG", help="MCAP file of 'tendond run'; of a set, any part.")]
LogFiles = Annotated[list[Path], typer.Argument(metavar="LOG...", help="MCAP files of 'tendond run'.")]

log = typer.Typer(name="log", help="Contents, repair and export of a log.", no_args_is_help=True, rich_markup_mode=None)


def add_to(app: typer.Typer) -> None:
    """Add the commands of this module."""
    for command in (replay, compare, plot, report, view):
        app.command()(command)
    app.add_typer(log)


def replay(
    file: LogFile,
    first: Annotated[int, typer.Option("--from", min=0, help="First cycle to compare.")] = 0,
    last: Annotated[int | None, typer.Option("--to", min=0, help="Last cycle to compare.")] = None,
    tolerance: Annotated[
        float | None,
        typer.Option("--tolerance", min=0.0, help="By which numbers may differ, of 1 or of their size: another CPU."),
    ] = None,
    jobs: Annotated[
        int | None, typer.Option("--jobs", "-j", min=1, max=1024, help="Processes. Left out: one per core.")
    ] = None,
    law: Annotated[
        str | None,
        typer.Option("--law", help="Another law than the log's, on the same inputs.", autocompletion=laws),
    ] = None,
    change: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Another parameter; may be repeated.")
    ] = None,
    closed_loop: Annotated[
        bool, typer.Option("--closed-loop", help="Run reference, loads and seeds again on the simulator.")
    ] = False,
    out: Annotated[
        Path | None, typer.Option("--out", help="Log to write with --law, --set, --closed-loop, a new one.")
    ] = None,
    json: Json = False,
) -> None:
    """Run a log again, and compare every cycle.

    Each must come out as it was recorded, to the last bit; exit status 1 if one does not.

    With --law or --set: what another law or parameter would have commanded on the same inputs. With --closed-loop: how
    the run would have gone. Both write a new log.

    Example: tendond replay run.mcap --law sliding_mode --set control.laws.sliding_mode.k=10
    """
    from tendond.cli.log.replay import run_replay, run_variant

    if law is None and not change and not closed_loop:
        if out is not None:
            raise typer.BadParameter("only with --law, --set or --closed-loop: a plain replay writes nothing")
        run_replay(file, first, last, tolerance, jobs, as_json=json)
        return
    if first or last is not None or tolerance is not None or jobs is not None:
        raise typer.BadParameter("--from, --to, --tolerance and --jobs do not go with --law, --set, --closed-loop")
    run_variant(file, law, change or [], out, closed_loop=closed_loop, as_json=json)


def compare(
    files: LogFiles,
    out: Annotated[Path, typer.Option("--out", help="Folder for table and figure.")] = Path("out/compare"),
    json: Json = False,
) -> None:
    """Put runs beside each other.

    A table of all metrics, and their curves in one figure.

    Example: tendond compare backstepping.mcap sliding_mode.mcap
    """
    from tendond.cli.log.logs import run_compare

    run_compare(files, out, as_json=json)


def plot(
    file: LogFile,
    out: Annotated[Path | None, typer.Option("--out", help="Folder for the figures. Left out: beside the log.")] = None,
    format: Annotated[str, typer.Option("--format", help="png, svg, or html: one interactive page.")] = "png",
) -> None:
    """Draw a run.

    The paper's panels, rod shapes, loop timing, modes and faults on a timeline.

    Example: tendond plot run.mcap --format html
    """
    from tendond.cli.log.logs import run_plot

    if format not in ("png", "svg", "html"):
        raise typer.BadParameter(f"'{format}': choose png, svg or html", param_hint="--format")
    run_plot(file, out, format)


def report(
    file: LogFile,
    out: Annotated[Path | None, typer.Option("--out", help="Page to write. Left out: LOG with .html.")] = None,
) -> None:
    """Write one page about a run.

    Numbers, figures, faults, configuration, versions; it needs no network and prints.

    Example: tendond report run.mcap
    """
    from tendond.cli.log.logs import run_report

    run_report(file, out)


def view(
    file: Annotated[Path | None, typer.Argument(metavar="[LOG]", help="To play. Left out: live from Zenoh.")] = None,
    config: Annotated[
        Path | None, typer.Option("--config", "-c", help="Rig configuration, TOML. Left out: the paper's robot.")
    ] = None,
    host: Annotated[str, typer.Option("--host", help="Address to serve at.")] = "127.0.0.1",
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="Port; 0: a free one.")] = 8765,
) -> None:
    """Serve a live rig, or a log, to Foxglove.

    Needs the extra 'view'.

    Open ws://localhost:8765 in Foxglove or Lichtblick, with the layout in deploy/foxglove.

    Examples: tendond view --config rig.toml; tendond view run.mcap
    """
    from tendond.cli.log.view import run_view
    from tendond.cli.signals import leave_on_signals

    leave_on_signals()
    run_view(file, config, host, port)


@log.command("info")
def log_info(file: LogFile, json: Json = False) -> None:
    """Say what is in a log and how it is.

    Times, cycles, modes, faults, versions, damage.

    Example: tendond log info run.mcap --json
    """
    from tendond.cli.log.logs import run_info

    run_info(file, as_json=json)


@log.command("recover")
def log_recover(
    file: LogFile,
    out: Annotated[Path | None, typer.Option("--out", help="New file. Left out: LOG-recovered.mcap.")] = None,
) -> None:
    """Save what is whole of a truncated or damaged file.

    It goes into a new one; what was lost is said.

    Example: tendond log recover run.mcap
    """
    from tendond.cli.log.logs import run_recover

    run_recover(file, out)


@log.command("export")
def log_export(
    file: LogFile,
    out: Annotated[Path | None, typer.Option("--out", help="CSV or Parquet file. Left out: LOG.csv.")] = None,
) -> None:
    """Write a table with a line per cycle.

    Units in the names of its columns; CSV, or Parquet (extra 'parquet').

    Example: tendond log export run.mcap --out run.parquet
    """
    from tendond.cli.log.logs import run_export

    run_export(file, out)
