"""The group `tendond log`: options and help of the commands that take a log."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.completion import configuration_settings, laws, logs
from tendond.cli.log.figure_commands import LogFile, animate, compare, plot
from tendond.cli.options import Config, Distro, Jobs, Json, known_distribution
from tendond.cli.program import say_renamed
from tendond.cli.rig.teach_commands import PathColumns, Smoothing
from tendond.drivers.ros2.distributions import DEFAULT_DISTRIBUTION

Law = Annotated[
    str | None, typer.Option("--law", help="Another control law than the recorded one.", autocompletion=laws)
]
Change = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="KEY=VALUE", help="Key to change; may be repeated.", autocompletion=configuration_settings
    ),
]
ClosedLoop = Annotated[
    bool, typer.Option("--closed-loop", help="Simulate the run again, with the recorded reference, loads and seeds.")
]

log = typer.Typer(
    name="log",
    help="List, inspect, replay, compare, plot, animate and repair logs.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@log.command("info")
def info(file: LogFile, json: Json = False) -> None:
    """Print the contents and health of a log.

    Times, cycles, modes, faults, versions, damage.

    Example: tendond log info run.mcap --json
    """
    from tendond.cli.log.logs import run_info

    run_info(file, as_json=json)


@log.command("replay")
def replay(
    file: LogFile,
    first: Annotated[int, typer.Option("--from", min=0, help="First cycle to compare.")] = 0,
    last: Annotated[int | None, typer.Option("--to", min=0, help="Last cycle to compare.")] = None,
    tolerance: Annotated[
        float | None,
        typer.Option("--tolerance", min=0.0, help="Absolute or relative tolerance, for logs from another CPU."),
    ] = None,
    jobs: Jobs = None,
    law: Annotated[str | None, typer.Option("--law", help="See log what-if.", hidden=True)] = None,
    change: Annotated[list[str] | None, typer.Option("--set", help="See log what-if.", hidden=True)] = None,
    closed_loop: Annotated[bool, typer.Option("--closed-loop", help="See log what-if.", hidden=True)] = False,
    out: Annotated[Path | None, typer.Option("--out", help="See log what-if.", hidden=True)] = None,
    json: Json = False,
) -> None:
    """Replay a log and compare every cycle.

    Every cycle must come out bit-identical to the recording. Exit status 1: one does not.

    Example: tendond replay run.mcap --from 100 --to 200
    """
    from tendond.cli.log.replay import run_replay

    if law is not None or change or closed_loop:
        if first or last is not None or tolerance is not None or jobs is not None:
            raise typer.BadParameter("--from, --to, --tolerance and --jobs do not go with --law, --set, --closed-loop")
        say_renamed("replay --law, --set, --closed-loop", "log what-if")
        what_if(file, law, change, closed_loop, out, json)
        return
    if out is not None:
        raise typer.BadParameter("a replay writes nothing; see 'tendond log what-if --help'", param_hint="--out")
    run_replay(file, first, last, tolerance, jobs, as_json=json)


@log.command("what-if")
def what_if(
    file: LogFile,
    law: Law = None,
    change: Change = None,
    closed_loop: ClosedLoop = False,
    out: Annotated[
        Path | None, typer.Option("--out", help="New log to write. Default: LOG-same-inputs or LOG-closed-loop.mcap.")
    ] = None,
    json: Json = False,
) -> None:
    """Replay a log with another law or parameter.

    Computes what the controller would have commanded on the recorded inputs; with --closed-loop, how the run would
    have gone. Writes a new log.

    Example: tendond log what-if run.mcap --law sliding_mode --set control.laws.sliding_mode.k=10
    """
    from tendond.cli.log.replay import run_variant

    if law is None and not change and not closed_loop:
        raise typer.BadParameter("give --law, --set or --closed-loop; without a change it is 'tendond replay'")
    run_variant(file, law, change or [], out, closed_loop=closed_loop, as_json=json)


log.command("compare")(compare)
log.command("plot")(plot)
log.command("animate")(animate)


@log.command("report")
def report(
    file: LogFile,
    out: Annotated[Path | None, typer.Option("--out", help="HTML page to write. Default: LOG.html.")] = None,
) -> None:
    """Write a one-page report of a run.

    Metrics, figures, faults, configuration, versions; self-contained and printable.

    Example: tendond log report run.mcap
    """
    from tendond.cli.log.logs import run_report

    run_report(file, out)


@log.command("recover")
def recover(
    file: LogFile,
    out: Annotated[Path | None, typer.Option("--out", help="New file. Default: LOG-recovered.mcap.")] = None,
) -> None:
    """Recover the intact part of a truncated file.

    Writes a new file and lists what was lost. Damaged files too.

    Example: tendond log recover run.mcap
    """
    from tendond.cli.log.logs import run_recover

    run_recover(file, out)


@log.command("export")
def export(
    file: LogFile,
    out: Annotated[
        Path | None,
        typer.Option("--out", help="CSV or Parquet file, or new folder. Default: LOG.csv, with --rosbag2 LOG-rosbag2."),
    ] = None,
    rosbag2: Annotated[
        bool, typer.Option("--rosbag2", help="A bag of ROS 2 instead: a folder with metadata and messages.")
    ] = False,
    distro: Distro = DEFAULT_DISTRIBUTION,
) -> None:
    """Export a table with a row per cycle, or a bag of ROS 2.

    Column names carry the units. CSV, or Parquet (extra 'parquet'). A bag (extra 'ros2') has poses, tendons, frames,
    the rod's shape and diagnostics.

    Examples: tendond log export run.mcap --out run.parquet; tendond log export --rosbag2 run.mcap --out run-bag
    """
    from tendond.cli.log.logs import run_bag_export, run_export

    if rosbag2:
        run_bag_export(file, out, known_distribution(distro))
        return
    run_export(file, out)


@log.command("smooth")
def smooth(
    file: LogFile,
    out: Annotated[
        Path | None, typer.Option("--out", help="CSV, Parquet or .npz file to write. Default: LOG-smoothed.csv.")
    ] = None,
    change: Change = None,
    json: Json = False,
) -> None:
    """Smooth a log: the likeliest shape, tip, load and errors.

    By all measurements before and after each cycle, with standard deviations; a table, and a figure beside it.

    Example: tendond log smooth run.mcap --set observer.pose_noise=2e-4 --out run.npz
    """
    from tendond.cli.log.smooth import run_smooth

    run_smooth(file, out, change or [], as_json=json)


@log.command("teach")
def teach(
    file: LogFile,
    out: Annotated[Path | None, typer.Option("--out", help="CSV file to write. Default: LOG-path.csv.")] = None,
    columns: PathColumns = None,
    smoothing: Smoothing = 0.1,
    first: Annotated[float, typer.Option("--from", min=0.0, help="First time to take [s].")] = 0.0,
    last: Annotated[float, typer.Option("--to", help="Last time to take [s].")] = float("inf"),
) -> None:
    """Write the measured path of the tip as a reference to play.

    Example: tendond log teach run.mcap --from 3 --to 12 --out path.csv
    """
    from tendond.cli.rig.teach import teach_from_log

    teach_from_log(file, out, columns, smoothing, (first, last))


@log.command("view")
def view(
    file: Annotated[
        Path | None,
        typer.Argument(metavar="[LOG]", help="Log to play. Default: live from Zenoh.", autocompletion=logs),
    ] = None,
    config: Config = None,
    host: Annotated[str, typer.Option("--host", help="Address to listen on.")] = "127.0.0.1",
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="Port to listen on; 0: a free one.")] = 8765,
) -> None:
    """Stream a log, or a live rig, to Foxglove.

    Needs the extra 'view'. Open ws://localhost:8765 in Foxglove or Lichtblick, with the layout in deploy/foxglove. A
    viewer that controls the playback can hold a log, jump in it and change its speed.

    Examples: tendond log view --config rig.toml; tendond log view run.mcap
    """
    from tendond.cli.log.view import run_view
    from tendond.cli.signals import exit_on_signals

    exit_on_signals()
    run_view(file, config, host, port)
