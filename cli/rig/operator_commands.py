"""An operator's commands: options and help."""

from typing import Annotated

import typer

from tendond.cli.completion import laws, reference_settings
from tendond.cli.options import Config, Json


def arm(
    config: Config = None,
    wait: Annotated[bool, typer.Option("--wait", help="Show the progress, and return when the arm tracks.")] = False,
) -> None:
    """Arm: pretension the tendons, then track the reference.

    The first time the tendons are probed before, which takes some seconds each; `--wait` shows how far it is. Ctrl-C
    ends the waiting alone: the controller goes on, until 'tendond stop'.

    Example: tendond arm --wait --config rig.toml
    """
    from tendond.cli.rig.operator import operate

    operate("arm", config)
    if wait:
        from tendond.cli.rig.arming import wait_for_tracking
        from tendond.cli.signals import exit_on_signals

        exit_on_signals()
        wait_for_tracking(config)


def stop(
    config: Config = None,
    wait: Annotated[bool, typer.Option("--wait", help="Return when the tendons are released.")] = False,
) -> None:
    """Stop tracking and release the tendons.

    Example: tendond stop --wait --config rig.toml
    """
    from tendond.cli.rig.operator import operate

    operate("stop", config)
    if wait:
        from tendond.cli.rig.arming import wait_for_idle
        from tendond.cli.signals import exit_on_signals

        exit_on_signals()
        wait_for_idle(config)


def reset(config: Config = None) -> None:
    """Clear a fault whose cause is gone.

    Example: tendond reset --config rig.toml
    """
    from tendond.cli.rig.operator import operate

    operate("reset", config)


def law(
    name: Annotated[str, typer.Argument(help="Name of the law, for instance sliding_mode.", autocompletion=laws)],
    config: Config = None,
) -> None:
    """Select another control law while the rig is idle.

    Its parameters are those of the configuration.

    Example: tendond rig law sliding_mode --config rig.toml
    """
    from tendond.cli.rig.operator import select_law

    select_law(name, config)


def reference(
    settings: Annotated[
        list[str],
        typer.Argument(
            metavar="KEY=VALUE...",
            help="Keys of [reference]; the others take their defaults.",
            autocompletion=reference_settings,
        ),
    ],
    config: Config = None,
) -> None:
    """Set another reference while the rig is idle.

    It is checked like the reference of a configuration.

    Example: tendond rig reference across=0.3 kind=minimum_jerk duration=2.0
    """
    from tendond.cli.rig.operator import set_reference

    set_reference(settings, config)


def status(
    config: Config = None,
    json: Json = False,
) -> None:
    """Print the controller's status.

    Example: tendond status --config rig.toml --json
    """
    from tendond.cli.rig.operator import show_status

    show_status(config, as_json=json)


def watch(
    config: Config = None,
    once: Annotated[bool, typer.Option("--once", help="Print one frame and exit.")] = False,
) -> None:
    """Watch a rig live in the terminal.

    Shows mode, tip and target, tensions, displacements, timing and faults, ten times a second, until Ctrl-C; a line
    each second where the output is not a terminal. Only listens; waits for a controller that is not running yet.

    Example: tendond watch --config rig.toml
    """
    from tendond.cli.rig.watch import run_watch
    from tendond.cli.signals import exit_on_signals

    exit_on_signals()
    run_watch(config, once=once)
