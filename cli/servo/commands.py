"""The group `tendond servo`: options and help."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.completion import logs
from tendond.cli.options import Config, Yes
from tendond.cli.signals import exit_on_signals

servo = typer.Typer(name="servo", rich_markup_mode=None)


@servo.callback(invoke_without_command=True)
def servo_run(context: typer.Context, config: Config = None) -> None:
    """Drive, find, set up and calibrate the servos.

    Without a command: drive the servos until Ctrl-C or SIGTERM, then release the tendons and switch the torque off.

    Example: tendond servo --config rig.toml
    """
    if context.invoked_subcommand is None:
        exit_on_signals()
        from tendond.cli.servo.servo import run_servo

        run_servo(config)


@servo.command("reset")
def servo_reset(
    config: Config = None,
    reboot: Annotated[bool, typer.Option("--reboot", help="Reboot servos that report a hardware error.")] = False,
) -> None:
    """Clear the driver's fault, or reopen its port.

    Example: tendond servo reset --config rig.toml
    """
    from tendond.cli.servo.servo import reset_servos

    reset_servos(config, reboot)


@servo.command("reboot")
def servo_reboot(
    servo_ids: Annotated[list[int], typer.Argument(metavar="ID...", min=0, max=252, help="Ids of the servos.")],
    config: Config = None,
    yes: Yes = False,
) -> None:
    """Reboot servos while no driver is running.

    Switches their torque off and clears hardware errors; the tendons' positions are remembered.

    Example: tendond servo reboot 2 --config rig.toml
    """
    from tendond.cli.servo.rig import ask_terminal
    from tendond.cli.servo.servo import reboot_servos

    reboot_servos(config, servo_ids, yes, ask_terminal)


@servo.command("scan")
def servo_scan(
    config: Config = None,
    port: Annotated[str | None, typer.Option("--port", help="Serial port. Default: every serial adapter.")] = None,
    last_id: Annotated[int, typer.Option("--last-id", min=0, max=252, help="Highest id to search.")] = 252,
) -> None:
    """Scan for servos: every port, rate and id.

    Nothing is moved or changed.

    Example: tendond servo scan --port /dev/ttyUSB0
    """
    exit_on_signals(130)
    from tendond.cli.servo.servo import scan_servos

    scan_servos(config, port, last_id)


@servo.command("setup")
def servo_setup(
    servo_id: Annotated[int, typer.Argument(metavar="ID", min=0, max=252, help="Current id of the servo.")],
    config: Config = None,
    new_id: Annotated[int | None, typer.Option("--new-id", min=0, max=252, help="New id. Default: unchanged.")] = None,
    at: Annotated[int | None, typer.Option("--at", help="Current baud rate. Default: the configured one.")] = None,
    yes: Yes = False,
) -> None:
    """Set a servo's id, rate, mode and limits.

    Example, a new servo: tendond servo setup 1 --new-id 3 --at 57600 --config rig.toml
    """
    from tendond.cli.servo.rig import ask_terminal
    from tendond.cli.servo.servo import set_up_servo

    set_up_servo(config, servo_id, new_id, at, yes, ask_terminal)


@servo.command("calibrate")
def servo_calibrate(config: Config = None) -> None:
    """Calibrate zero, sign and spool of each tendon.

    Writes the calibration; an unfinished one can be resumed.

    Example: tendond servo calibrate --config rig.toml
    """
    exit_on_signals(130)
    from tendond.cli.servo.rig import ask_terminal
    from tendond.cli.servo.tendons import calibrate_servos

    calibrate_servos(config, ask_terminal)


@servo.command("home")
def servo_home(
    config: Config = None,
    yes: Yes = False,
    at: Annotated[
        list[str] | None,
        typer.Option("--at", metavar="TENDON=MM", help="Position of a tendon whose servo has lost count of its turns."),
    ] = None,
) -> None:
    """Move every tendon slowly to its zero.

    Example: tendond servo home --config rig.toml
    """
    from tendond.cli.servo.rig import ask_terminal
    from tendond.cli.servo.tendons import home_servos

    home_servos(config, yes, ask_terminal, at)


@servo.command("pretension")
def servo_pretension(
    config: Config = None,
    store: Annotated[bool, typer.Option("--store", help="Store the positions found as new zeros.")] = False,
    yes: Yes = False,
) -> None:
    """Take up slack until every tendon pulls.

    Example: tendond servo pretension --config rig.toml --store
    """
    from tendond.cli.servo.rig import ask_terminal
    from tendond.cli.servo.tendons import pretension_servos

    pretension_servos(config, store, yes, ask_terminal)


@servo.command("identify")
def servo_identify(
    tendon: Annotated[int, typer.Argument(metavar="TENDON", min=0, max=15, help="Number of a slack tendon.")],
    config: Config = None,
    travel: Annotated[
        float, typer.Option("--travel", min=1.0, max=50.0, help="Length that is paid out and taken up again [mm].")
    ] = 6.0,
    log: Annotated[
        Path | None,
        typer.Option(
            "--log", help="Recorded run to fit to; nothing is moved, and no servo is needed.", autocompletion=logs
        ),
    ] = None,
    yes: Yes = False,
) -> None:
    """Identify a servo by steps of a slack tendon, or a log.

    Fits dead time, lag, speed and acceleration to the servo's own readings, and prints keys for the configuration. Only
    slack is made and taken up. Refused while the rig is armed, or its servo driver runs.

    Example: tendond servo identify 0 --config rig.toml
    """
    from tendond.cli.servo.identify import identify_from_log, identify_servo
    from tendond.cli.servo.rig import ask_terminal

    if log is not None:
        identify_from_log(log, tendon)
    else:
        identify_servo(config, tendon, 1e-3 * travel, yes, ask_terminal)
