"""Studies: their options and their help; what they do stands in the modules that they import."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.options import Config, Json
from tendond.cli.signals import leave_on_signals

study = typer.Typer(
    name="study", help="Show what the controller bears, on simulated rigs.", no_args_is_help=True, rich_markup_mode=None
)

Processes = Annotated[
    int | None, typer.Option("--processes", min=1, help="To share the work. Default: one per processor.")
]


def processor_count() -> int:
    """Processors that this process may use."""
    import os

    return len(os.sched_getaffinity(0))


@study.command("margin")
def study_margin(
    config: Config = None,
    json: Json = False,
    short: Annotated[bool, typer.Option("--short", help="Only the corners, at 100 Hz.")] = False,
    processes: Processes = None,
) -> None:
    """Show the loop's margin for a mass on the tip.

    Prints the gains that the margin admits, the stiffness of the bent arm, and runs of the real loop with masses that
    the controller does not know. Exit status 1 where a run does not settle or swings by more than 0.2 mm.

    Example: tendond study margin --short
    """
    leave_on_signals(130)
    from tendond.cli.study.margin import run_margin

    if not run_margin(config, json, short, processes or processor_count()):
        raise typer.Exit(1)


@study.command("wiring")
def study_wiring(
    law: Annotated[list[str] | None, typer.Option("--law", help="Only this law; may be repeated.")] = None,
    row: Annotated[list[str] | None, typer.Option("--row", help="Only this kind of mistake; may be repeated.")] = None,
    setups: Annotated[int, typer.Option("--setups", min=0, max=1_000_000, help="Right rigs, drawn at random.")] = 100,
    processes: Processes = None,
    out: Annotated[Path | None, typer.Option("--out", help="File for the table, as Markdown.")] = None,
    json: Json = False,
) -> None:
    """Arm wrongly wired rigs, and right ones.

    Every mistake of a camera's frame, of lengths and quaternions, of the tendons' order, sign and spools, poses of
    another robot and old ones, for each law, with ideal tendons and with servos: refused or in fault before the tip has
    moved far or anything pulls hard? And no alarm on right rigs? The exit status is 1 where a row falls short.

    In lockstep; takes several minutes.

    Example: tendond study wiring --setups 1000 --out out/wiring.md
    """
    leave_on_signals(130)
    from tendond.cli.study.wiring import run_wiring
    from tendond.daemon.control.laws import LAWS

    for name in law or ():
        if name not in LAWS:
            raise typer.BadParameter(f"'{name}': choose among {', '.join(LAWS)}", param_hint="--law")
    if not run_wiring(tuple(law or ()), setups, tuple(row or ()), processes, out, as_json=json):
        raise typer.Exit(1)


def add_to(app: typer.Typer) -> None:
    """Add these commands."""
    app.add_typer(study)
