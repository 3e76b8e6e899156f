"""`tendond doctor`: its options and its help; what it does stands in the modules that it imports."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.options import Config
from tendond.cli.signals import leave_on_signals


def doctor(
    config: Config = None,
    log: Annotated[
        Path | None, typer.Option("--log", help="Folder of the logs. Left out: where 'tendond run' logs to.")
    ] = None,
    servos: Annotated[
        bool, typer.Option("--servos/--no-servos", help="Ask servos that no driver has how they are.")
    ] = True,
    probe: Annotated[
        bool, typer.Option("--probe", help="Have the controller pull each tendon a little, and let go: the arm moves.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="For programs.")] = False,
) -> None:
    """Look for what is wrong with a rig.

    Computer, configuration, bus, poses, servos. Nothing is moved or changed, unless --probe asks for it. Each line is
    pass, warn or fail; the exit status is 1 where one failed, 2 where it is the configuration.

    Examples: tendond doctor -c rig.toml; sudo -u tendond tendond doctor -c /etc/tendond/RIG/rig.toml
    """
    leave_on_signals(130)
    from tendond.cli.doctor.report import examine

    examine(config, log, ask_servos=servos, as_json=as_json, probe=probe)


def add_to(app: typer.Typer) -> None:
    """Add the commands of this module."""
    app.command()(doctor)
