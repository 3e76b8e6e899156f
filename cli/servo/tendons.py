"""`tendond servo calibrate`, `home` and `pretension`."""

from pathlib import Path

from tendond.cli.common import stop_on_signals
from tendond.cli.servo.rig import confirm, parse_places, servo_rig
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.tools.all_tendons import home_all, pretension_all, store_zeros
from tendond.drivers.dynamixel.tools.calibrate import Ask, calibrate
from tendond.drivers.dynamixel.tools.rig import open_bus


def calibrate_servos(config_file: Path | None, ask: Ask) -> None:
    """Calibrate every tendon, or resume an unfinished calibration.

    Raises:
        TendondError: an error of a servo, something that does not fit, or a file that cannot be written.
    """
    calibrate(servo_rig(config_file), ask, print)


def home_servos(config_file: Path | None, yes: bool, ask: Ask, at: list[str] | None = None) -> None:
    """Move every tendon to its zero, once the operator has confirmed it.

    Raises:
        TendondError: no calibration, an error of a servo, or the operator said no.
    """
    rig = servo_rig(config_file)
    stopped = stop_on_signals()
    calibration = rig.calibration()
    given = parse_places(at or [], len(rig.ids))
    with open_bus(rig.section) as bus:
        located = rig.locate(bus, calibration, given)
        for index, one in enumerate(located):
            servo = one.spool.calibration.servo
            held = bool(bus.read(servo, table.TORQUE_ENABLE))
            place = one.doubt or f"stands {one.displacement * 1e3:.1f} mm from its zero"
            print(f"tendon {index} (servo {servo}): {place}{', held' if held else ''}")
        confirm("Move them to zero, slowly, one after the other?", yes, ask)
        for moved in home_all(rig, bus, calibration, located, stopped):
            print(f"tendon {moved.tendon}: from {moved.before * 1e3:.1f} to {moved.after * 1e3:.1f} mm")


def pretension_servos(config_file: Path | None, store: bool, yes: bool, ask: Ask) -> None:
    """Take up the slack of every tendon; with `store`, where it pulls becomes its zero.

    Raises:
        TendondError: no calibration, an error of a servo, or the operator said no.
    """
    rig = servo_rig(config_file)
    stopped = stop_on_signals()
    calibration = rig.calibration()
    taut = []
    with open_bus(rig.section) as bus:
        confirm("Take up the slack of each tendon, slowly, one after the other, until it pulls?", yes, ask)
        for one in pretension_all(rig, bus, calibration, stopped):
            print(f"tendon {one.tendon} (servo {one.servo}): pulls from {one.displacement * 1e3:.2f} mm on")
            taut.append(one)
    if store:
        kept = store_zeros(rig, calibration, taut)
        aside = "" if kept is None else f"; the old ones are in {kept.name}"
        print(f"{rig.calibration_file}: the new zeros{aside}")
