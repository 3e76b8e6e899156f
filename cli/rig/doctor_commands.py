"""`tendond rig doctor`: options and help."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.options import Config
from tendond.cli.signals import exit_on_signals


def doctor(
    config: Config = None,
    log: Annotated[
        Path | None, typer.Option("--log", help="Folder of the logs. Default: where 'tendond run' writes them.")
    ] = None,
    servos: Annotated[bool, typer.Option("--servos/--no-servos", help="Query servos not in use by a driver.")] = True,
    probe: Annotated[
        bool,
        typer.Option("--probe", help="Let the controller pull each tendon slightly and release it: the arm moves."),
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Diagnose a rig.

    Checks computer, configuration, bus, poses and servos. Nothing is moved or changed, except with --probe. Each line
    is pass, warn or fail. Exit status 1: a check failed; 2: invalid configuration.

    Examples: tendond doctor -c rig.toml; sudo -u tendond tendond doctor -c /etc/tendond/RIG/rig.toml
    """
    exit_on_signals(130)
    from tendond.cli.doctor.report import examine

    examine(config, log, query_servos=servos, as_json=as_json, probe=probe)
