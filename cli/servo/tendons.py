"""`tendond servo home` and `pretension`: tendons brought to their zero, and slack taken up."""

from pathlib import Path

from tendond.cli.common import stop_on_signals
from tendond.cli.servo.rig import Ask, confirm, open_bus, parse_places, servo_rig
from tendond.drivers.dynamixel.calibration import Calibration, now, save_calibration, set_aside
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.tools.tendons import home, pretension


def home_servos(config_file: Path | None, yes: bool, ask: Ask, at: list[str] | None = None) -> None:
    """Bring every tendon to its zero, one after the other, slowly: first those that are wound up.

    Raises:
        TendondError: no calibration, an error of a servo, or the operator said no.
    """
    rig = servo_rig(config_file)
    stopped = stop_on_signals()
    calibration = rig.calibration()
    told = parse_places(at or [], len(rig.ids))
    with open_bus(rig.section) as bus:
        located = rig.locate(bus, calibration, told)
        for index, one in enumerate(located):
            servo = one.spool.calibration.servo
            held = bool(bus.read(servo, table.TORQUE_ENABLE))
            place = one.doubt or f"stands {one.displacement * 1e3:.1f} mm from its zero"
            print(f"tendon {index} (servo {servo}): {place}{', held' if held else ''}")
        confirm("Move them to zero, slowly, one after the other?", yes, ask)
        for index in sorted(range(len(located)), key=lambda one: -located[one].displacement):
            before, after = home(bus, rig.section, located[index], rig.tension_max, stopped)
            rig.keep(calibration, {located[index].spool.calibration.servo: after})
            print(f"tendon {index}: from {before * 1e3:.1f} to {after * 1e3:.1f} mm")


def pretension_servos(config_file: Path | None, store: bool, yes: bool, ask: Ask) -> None:
    """Wind every tendon up until it pulls; with `store`, that is its zero from now on.

    Raises:
        TendondError: no calibration, an error of a servo, or the operator said no.
    """
    rig = servo_rig(config_file)
    stopped = stop_on_signals()
    calibration = rig.calibration()
    tendons = list(calibration.tendons)
    places = {}
    with open_bus(rig.section) as bus:
        confirm("Wind up each tendon, slowly, one after the other, until it pulls?", yes, ask)
        located = rig.locate(bus, calibration, {})
        for index, one in enumerate(located):
            spool = one.spool
            taut = pretension(bus, rig.section, spool, rig.tension_max, stopped)
            places[spool.calibration.servo] = spool.displacement(taut)
            rig.keep(calibration, places)
            place = spool.displacement(taut) * 1e3
            print(f"tendon {index} (servo {spool.calibration.servo}): pulls from {place:.2f} mm on")
            tendons[index] = spool.calibration.model_copy(update={"zero": taut % table.TICKS_PER_TURN})
    if store:
        kept = set_aside(rig.calibration_file)
        anew = Calibration(rig=calibration.rig, date=now(), tendons=tuple(tendons))
        save_calibration(rig.calibration_file, anew)
        rig.keep(anew, dict.fromkeys(places, 0.0))
        aside = "" if kept is None else f"; the old ones are in {kept.name}"
        print(f"{rig.calibration_file}: the new zeros{aside}")
