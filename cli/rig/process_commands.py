"""The processes of a rig: options and help."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.completion import faults
from tendond.cli.options import Config, Cycles, Lockstep, PlantName, Profile
from tendond.cli.signals import exit_on_signals


def run(
    config: Config = None,
    profile: Profile = None,
    log: Annotated[
        Path | None, typer.Option("--log", help="New MCAP file to write. Default: log/RIG-TIME.mcap.")
    ] = None,
    lockstep: Lockstep = False,
    cycles: Cycles = None,
    arm_at: Annotated[
        int | None, typer.Option("--arm-at", min=0, help="Cycle to arm at; with --lockstep only.")
    ] = None,
    note: Annotated[
        list[str] | None,
        typer.Option(
            "--note", help="KEY=VALUE for the log's metadata, such as weight=0.05 [kg] for identify; may be repeated."
        ),
    ] = None,
) -> None:
    """Run the controller; it starts disarmed.

    Runs until Ctrl-C or SIGTERM; releases the tendons before exiting.

    Example: tendond run --config rig.toml
    """
    exit_on_signals()
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
        bool,
        typer.Option("--wired", help="Emulate servos on a serial port and Tracker on UDP, for the real drivers."),
    ] = False,
    plant: PlantName = None,
) -> None:
    """Simulate the robot, with or without its drivers.

    Replaces camera and servos; with --wired, the hardware behind their drivers. Runs until Ctrl-C or SIGTERM.

    --plant mujoco simulates the configured robot in MuJoCo, of which the controller's rod model shares no line.

    Examples: tendond simulate --config rig.toml; tendond simulate --profile rig; tendond simulate --plant mujoco
    """
    exit_on_signals()
    from tendond.cli.rig.simulate import run_simulator, run_wired

    if wired:
        if lockstep or cycles is not None:
            raise typer.BadParameter("--wired runs on the clock, without --lockstep and --cycles")
        if profile is not None:
            raise typer.BadParameter("--wired needs --config, with the sections [servo] and [vicon] or [mocap]")
        run_wired(config, plant)
        return
    run_simulator(config, profile, lockstep=lockstep, cycles=cycles, plant=plant)


def inject(
    fault: Annotated[
        str, typer.Argument(help="Name of the fault, see docs/simulator.md; clear ends it.", autocompletion=faults)
    ],
    config: Config = None,
    servo_id: Annotated[
        int | None, typer.Option("--servo", help="Id of the servo; without --wired, the first is 1.")
    ] = None,
    seconds: Annotated[float | None, typer.Option("--seconds", help="Duration [s].")] = None,
    size: Annotated[float | None, typer.Option("--size", help="Size [m, kg, N, or a fraction].")] = None,
    direction: Annotated[str | None, typer.Option("--direction", help="x, -x, y, -y, z or -z.")] = None,
    place: Annotated[float | None, typer.Option("--place", help="Position along the rod; the tip is 1.")] = None,
    sensor: Annotated[str | None, typer.Option("--sensor", help="Name of the sensor.")] = None,
    rows: Annotated[
        list[int] | None, typer.Option("--row", help="Row of its readings, from 0; may be repeated.")
    ] = None,
) -> None:
    """Inject a fault into a running 'tendond simulate'.

    Camera and arm: occlusion, frozen, teleport, dropout, noise, weight, impact, silence. Servos: overload, stuck, cut;
    with --wired also silent, hot, reboot. Serial bus, with --wired: crc, unplug, plug. Sensors: unseen, swapped, mute.

    Examples: tendond rig inject weight --size 0.05; tendond rig inject overload --servo 3 --config rig.toml
    """
    from tendond.cli.rig.simulate import inject_fault

    options = {"servo": servo_id, "seconds": seconds, "size": size, "direction": direction, "place": place}
    inject_fault(config, fault, {**options, "sensor": sensor, "rows": rows or None})


def vicon(config: Config = None) -> None:
    """Publish tip poses from Vicon Tracker.

    The older name of `tendond mocap`.

    Runs until Ctrl-C or SIGTERM.

    Example: tendond rig vicon --config rig.toml
    """
    exit_on_signals()
    from tendond.cli.rig.cameras import run_cameras

    run_cameras(config, "vicon")
