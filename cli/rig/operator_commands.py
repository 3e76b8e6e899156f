"""An operator's commands: their options and their help; what they do stands in the modules that they import."""

from typing import Annotated

import typer

from tendond.cli.options import Config, Json, laws


def arm(config: Config = None) -> None:
    """Arm: pretension, then track the reference.

    Example: tendond arm --config rig.toml
    """
    from tendond.cli.rig.operator import operate

    operate("arm", config)


def stop(config: Config = None) -> None:
    """Stop tracking and release the tendons.

    Example: tendond stop --config rig.toml
    """
    from tendond.cli.rig.operator import operate

    operate("stop", config)


def reset(config: Config = None) -> None:
    """Leave the fault mode, once its cause is gone.

    Example: tendond reset --config rig.toml
    """
    from tendond.cli.rig.operator import operate

    operate("reset", config)


def law(
    name: Annotated[str, typer.Argument(help="Of the law, for instance sliding_mode.", autocompletion=laws)],
    config: Config = None,
) -> None:
    """Select another control law while the arm is idle.

    Its parameters are the configuration's.

    Example: tendond law sliding_mode --config rig.toml
    """
    from tendond.cli.rig.operator import select_law

    select_law(name, config)


def reference(
    settings: Annotated[
        list[str], typer.Argument(metavar="KEY=VALUE...", help="Keys of [reference]; the others have their defaults.")
    ],
    config: Config = None,
) -> None:
    """Set another reference while the arm is idle.

    It is checked as the configuration's would be.

    Example: tendond reference across=0.3 kind=minimum_jerk duration=2.0
    """
    from tendond.cli.rig.operator import set_reference

    set_reference(settings, config)


def status(
    config: Config = None,
    json: Json = False,
) -> None:
    """Print what the controller is doing.

    Example: tendond status --config rig.toml --json
    """
    from tendond.cli.rig.operator import show_status

    show_status(config, as_json=json)


def watch(
    config: Config = None,
    once: Annotated[bool, typer.Option("--once", help="Print one frame and leave.")] = False,
) -> None:
    """Watch a rig live in the terminal.

    Mode, tip and target, tensions, displacements, timing, faults, ten times a second, until Ctrl-C; where the output is
    no terminal, a line each second. It only listens, and waits for a controller that is not there.

    Example: tendond watch --config rig.toml
    """
    from tendond.cli.rig.watch import run_watch
    from tendond.cli.signals import leave_on_signals

    leave_on_signals()
    run_watch(config, once=once)


def add_to(app: typer.Typer) -> None:
    """Add the commands of this module."""
    for command in (arm, stop, reset, law, reference, status, watch):
        app.command()(command)
