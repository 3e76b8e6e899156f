"""Checks of servos before they are used: they reply, and accept every goal of the travel."""

from collections.abc import Sequence

from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import TRIES, NoReplyError, ServoBus, ServoError
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


def within_range(section: ServoSection, spool: Spool) -> None:
    """Check that a servo accepts every goal of the travel.

    Raises:
        ServoError: it counts too many turns: the limit is 256.
    """
    for displacement in (section.displacement_min, section.displacement_max):
        ticks = spool.ticks(displacement)
        if not table.GOAL_POSITION.minimum <= ticks <= table.GOAL_POSITION.maximum:
            raise ServoError(
                f"servo {spool.calibration.servo}: counts {spool.turns} turns, with the travel more than the 256 of its"
                " goal's range: switch its power off and on"
            )
