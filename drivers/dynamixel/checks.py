"""Checks of servos before they are used: they reply, and accept every goal of the travel."""

from collections.abc import Sequence

from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import TRIES, NoReplyError, ServoBus, ServoError
from tendond.drivers.dynamixel.serial.model import ServoModel
from tendond.drivers.dynamixel.spool import Spool
from tendond.schemas.config.servo import WATCHDOG_UNIT, ServoSection


def find(bus: ServoBus, identifiers: Sequence[int], tries: int = TRIES) -> None:
    """Check that servos reply.

    Raises:
        NoReplyError: one does not, with the remedy.
    """
    missing = bus.absent(identifiers, tries)
    if missing:
        names = ", ".join(map(str, missing))
        raise NoReplyError(
            f"{bus.port}: no reply from servo {names}: is it powered, and are its id and rate right? Try"
            f" 'tendond servo scan'{bus.transport.late.text}"
        )


def watchdog_units(section: ServoSection) -> int:
    """Return `servo.watchdog` in units of the Bus Watchdog."""
    return max(2, round(section.watchdog / WATCHDOG_UNIT))


def profile_units(model: ServoModel, section: ServoSection) -> tuple[int, int]:
    """Return the configured Profile Velocity and Acceleration in units of their registers.

    Neither is rounded to 0, which means no limit.
    """
    velocity = max(1, int(section.profile_velocity / model.velocity_unit))
    acceleration = round(section.profile_acceleration / model.acceleration_unit)
    if section.profile_acceleration > 0.0:
        acceleration = max(1, acceleration)
    return (
        min(velocity, model.entry(table.PROFILE_VELOCITY).maximum),
        min(acceleration, model.entry(table.PROFILE_ACCELERATION).maximum),
    )


def within_range(section: ServoSection, spool: Spool, model: ServoModel) -> None:
    """Check that a servo of a model accepts every goal of the travel.

    Raises:
        ServoError: it counts too many turns: the limit of the X series is 256.
    """
    goal = model.entry(table.GOAL_POSITION)
    largest = goal.maximum // spool.calibration.ticks_per_turn
    for displacement in (section.displacement_min, section.displacement_max):
        ticks = spool.ticks(displacement)
        if not goal.minimum <= ticks <= goal.maximum:
            raise ServoError(
                f"servo {spool.calibration.servo}: counts {spool.turns} turns, with the travel more than the"
                f" {largest + 1} of its goal's range: switch its power off and on"
            )
