"""`tendond rig teach`: options and help."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from tendond.cli.completion import reference_settings
from tendond.cli.options import Config

teach = typer.Typer(
    name="teach", help="Record a path that somebody shows, and play it.", no_args_is_help=True, rich_markup_mode=None
)

PathColumns = Annotated[
    Literal["direction", "position", "xz", "yz"] | None,
    typer.Option("--columns", help="Columns beside the time. Default: what the rig's law and robot follow."),
]
Smoothing = Annotated[
    float, typer.Option("--smoothing", min=0.0, max=2.0, help="Standard deviation of the filter in time [s].")
]


@teach.command("record")
def record(
    out: Annotated[Path, typer.Option("--out", help="CSV file to write.")] = Path("path.csv"),
    duration: Annotated[float | None, typer.Option("--duration", min=0.5, help="Seconds. Default: to Ctrl-C.")] = None,
    columns: PathColumns = None,
    smoothing: Smoothing = 0.1,
    config: Config = None,
) -> None:
    """Record the tip's poses and write them as a reference.

    Move the arm by hand while the rig is idle, its servos without torque; or let it run. Stillness at the beginning and
    the end is left out.

    Example: tendond rig teach record --out path.csv --duration 10 --config rig.toml
    """
    from tendond.cli.common import stop_on_signals
    from tendond.cli.rig.teach import record as run

    run(config, out, duration, columns, smoothing, stop_on_signals())


@teach.command("play")
def play(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="CSV file that was recorded.")],
    settings: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[KEY=VALUE]...", help="Further keys of [reference].", autocompletion=reference_settings
        ),
    ] = None,
    config: Config = None,
) -> None:
    """Set a recorded path as the reference while the rig is idle.

    It is checked like every reference: where the tip cannot rest, the nearest place is named. 'tendond arm' starts it.

    Example: tendond rig teach play path.csv moved_max=0.01 --config rig.toml
    """
    from tendond.cli.rig.teach import play as run

    run(config, file, settings or [])
