"""`tendond teleop`: options and help."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.options import Config


def teleop(
    gamepad: Annotated[
        str | None,
        typer.Option("--gamepad", help="Event device of a gamepad, or auto for the first one. Default: keys."),
    ] = None,
    speed: Annotated[
        float, typer.Option("--speed", min=0.01, max=1.0, help="Part of teleop.speed_max at full deflection.")
    ] = 1.0,
    record: Annotated[
        Path | None, typer.Option("--record", help="Write the measured path as a reference, as rig teach record does.")
    ] = None,
    config: Config = None,
) -> None:
    """Move the tracking arm by hand: keys or a gamepad.

    Its target moves along the tips of resting shapes, within speed, acceleration and workspace. Nothing moves unless a
    key or the gamepad's shoulder button is held. Without this program the target holds its place.

    Example: tendond teleop --gamepad auto --record path.csv --config rig.toml
    """
    from tendond.cli.common import stop_on_signals
    from tendond.cli.teleop.run import run_teleop

    run_teleop(config, gamepad=gamepad, part=speed, record=record, stopped=stop_on_signals())
