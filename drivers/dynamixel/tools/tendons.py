"""Homing and pretension of a tendon before the driver runs. One servo moves at a time, slowly, monitored as in
operation; after every motion the tendon is released and the torque is off.
"""

from collections.abc import Callable

from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import ServoBus, ServoError
from tendond.drivers.dynamixel.spool import Spool
from tendond.drivers.dynamixel.tools.motion import energised
from tendond.drivers.dynamixel.turns import Located
from tendond.schemas.config.servo import ServoSection

NEVER = 2.0
"""Load that is never reached, as a fraction of the stall torque."""


def home(
    bus: ServoBus,
    section: ServoSection,
    located: Located,
    tension_max: float,
    stopped: Callable[[], bool] = lambda: False,
) -> tuple[float, float]:
    """Move a tendon slowly to its zero; the torque is off afterwards.

    The motion stays within the travel, and takes up slack only of a tendon that is known to be slack.

    Args:
        bus: open.
        section: [servo].
        located: where the tendon is.
        tension_max: limits.tension_max [N].
        stopped: true when the operator interrupts it.

    Returns:
        Displacement before and after [m].

    Raises:
        ServoError: its place is unknown, an error of the servo, a tendon that pulls before it is at zero, or it was
            interrupted.
    """
    spool = located.spool
    servo = spool.calibration.servo
    if located.doubt:
        raise ServoError(f"servo {servo}: {located.doubt}: measure it and give it with --at")
    beyond = section.home_window
    if not section.displacement_min - beyond <= located.displacement <= section.displacement_max + beyond:
        raise ServoError(
            f"servo {servo}: stands {located.displacement * 1e3:.1f} mm from its zero, outside its travel: turn it by"
            " hand with its power off, or calibrate again"
        )
    with energised(bus, section, spool, tension_max) as motion:
        before = motion.displacement
        # In a release the load decreases; taking up slack there must be none, else the zero has changed.
        motion.move(0.0, NEVER if before > 0.0 else 2.0 * section.pretension_load, stopped)
        after = motion.displacement
        if abs(after) > motion.arrival:
            raise ServoError(f"servo {motion.id}: load {motion.load:.0%} at {after * 1e3:.1f} mm, stopped")
    return before, after


def pretension(
    bus: ServoBus,
    section: ServoSection,
    spool: Spool,
    tension_max: float,
    stopped: Callable[[], bool] = lambda: False,
) -> int:
    """Take up a tendon's slack, slowly, until its load shows that it is taut; the torque is off afterwards.

    Returns:
        Position at which it began to pull [ticks].

    Raises:
        ServoError: it pulls already, no load came within reach, an error of the servo, or it was stopped.
    """
    with energised(bus, section, spool, tension_max) as motion:
        start = motion.rest()
        if motion.load >= section.pretension_load:
            raise ServoError(f"servo {motion.id}: pulls already (load {motion.load:.0%}): slacken it")
        target = spool.displacement(start.position) + section.pretension_reach
        reading = motion.move(target, section.pretension_load, stopped)
        if motion.load < section.pretension_load:
            raise ServoError(
                f"servo {motion.id}: no load within {section.pretension_reach * 1e3:g} mm: is the tendon on its spool,"
                " its sign right?"
            )
        if reading.load * spool.calibration.sign < 0:
            raise ServoError(f"servo {motion.id}: the load acts in the direction of the pull: is its sign right?")
    return reading.position


def take_over(bus: ServoBus, section: ServoSection, servo: int) -> bool:
    """Switch off a servo that an interrupted tool has left on; true where it was on.

    Raises:
        ServoError: its load is higher than that of a tendon without slack, and must not be dropped.
    """
    if not bus.read(servo, table.TORQUE_ENABLE):
        return False
    load = abs(bus.read(servo, bus.model.load)) * bus.model.load_unit
    if load > 2.0 * section.pretension_load:
        raise ServoError(
            f"servo {servo}: holds a load of {load:.0%}: run 'tendond servo home' if it is calibrated, or support the"
            f" robot and 'tendond servo reboot {servo}'"
        )
    bus.write(servo, table.TORQUE_ENABLE, 0)
    bus.write(servo, table.BUS_WATCHDOG, 0)
    return True
