"""The processes of a rig: their options and their help; what they do stands in the modules that they import."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.options import Config, Cycles, Lockstep, Profile, faults
from tendond.cli.signals import leave_on_signals


def run(
    config: Config = None,
    profile: Profile = None,
    log: Annotated[
        Path | None, typer.Option("--log", help="MCAP file to write, a new one. Left out: log/RIG-TIME.mcap.")
    ] = None,
    lockstep: Lockstep = False,
    cycles: Cycles = None,
    arm_at: Annotated[
        int | None, typer.Option("--arm-at", min=0, help="Cycle to arm at; with --lockstep only.")
    ] = None,
    note: Annotated[
        list[str] | None,
        typer.Option("--note", help="KEY=VALUE for the log's metadata, as weight=0.05 [kg] for identify; repeatable."),
    ] = None,
) -> None:
    """Run the controller; it starts disarmed.

    Until Ctrl-C or SIGTERM, which release the tendons first.

    Example: tendond run --config rig.toml
    """
    leave_on_signals()
    from tendond.cli.rig.run import run_controller

    if arm_at is not None and not lockstep:
        raise typer.BadParameter("only with --lockstep: a controller on a clock is armed by 'tendond arm'")
    notes = {}
    for text in note or ():
        key, sign, value = text.partition("=")
        if not key or not sign:
            raise typer.BadParameter(f"'{text}': give KEY=VALUE", param_hint="--note")
        notes[key] = value
    run_controller(config, profile, log, lockstep=lockstep, cycles=cycles, arm_at=arm_at, notes=notes)


def simulate(
    config: Config = None,
    profile: Profile = None,
    lockstep: Lockstep = False,
    cycles: Cycles = None,
    wired: Annotated[
        bool, typer.Option("--wired", help="Emulate servos on a serial port and Tracker on UDP, for the real drivers.")
    ] = False,
) -> None:
    """Run the simulated robot instead of camera and servos.

    Or behind their drivers, with --wired.

    Examples: tendond simulate --config rig.toml; tendond simulate --profile rig
    """
    leave_on_signals()
    from tendond.cli.rig.simulate import run_simulator, run_wired

    if wired:
        if lockstep or cycles is not None:
            raise typer.BadParameter("--wired goes by the clock, without --lockstep and --cycles")
        if profile is not None:
            raise typer.BadParameter("--wired needs --config, with the sections [servo] and [vicon]")
        run_wired(config)
        return
    run_simulator(config, profile, lockstep=lockstep, cycles=cycles)


def inject(
    fault: Annotated[str, typer.Argument(help="Which, see docs/simulator.md; mend ends it.", autocompletion=faults)],
    config: Config = None,
    servo_id: Annotated[
        int | None, typer.Option("--servo", help="Id of the servo; of 'simulate', the first is 1.")
    ] = None,
    seconds: Annotated[float | None, typer.Option("--seconds", help="For how long.")] = None,
    size: Annotated[float | None, typer.Option("--size", help="How much [m, kg, N, or a part].")] = None,
    direction: Annotated[str | None, typer.Option("--direction", help="x, -x, y, -y, z or -z.")] = None,
    place: Annotated[float | None, typer.Option("--place", help="Along the rod, where 1 is the tip.")] = None,
) -> None:
    """Cause a fault on a running 'tendond simulate'.

    With --wired or without.

    Of camera and arm: occlusion, frozen, teleport, dropout, noise, weight, impact, silence. Of a servo: overload,
    stuck, cut; with --wired also silent, hot, reboot, and of the bus crc, unplug, plug.

    Examples: tendond inject weight --size 0.05; tendond inject overload --servo 3 --config rig.toml
    """
    from tendond.cli.rig.simulate import inject_fault

    options = {"servo": servo_id, "seconds": seconds, "size": size, "direction": direction, "place": place}
    inject_fault(config, fault, options)


def vicon(config: Config = None) -> None:
    """Publish tip poses from Vicon Tracker.

    Until Ctrl-C or SIGTERM.

    Example: tendond vicon --config rig.toml
    """
    leave_on_signals()
    from tendond.cli.rig.vicon import run_vicon

    run_vicon(config)


def add_to(app: typer.Typer) -> None:
    """Add the commands of this module."""
    for command in (run, simulate, inject, vicon):
        app.command()(command)
