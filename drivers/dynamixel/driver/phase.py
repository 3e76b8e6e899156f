"""Phases of the servo driver, and those into which the commands and the time lead. Reads no clock.

off --armed--> on --command stream lost--> holding --> silent (no packets: the servos' watchdog stops them)
on or holding --fault--> stopped --> releasing --> off        on --disarmed--> releasing --> off
any --port gone--> lost
"""

from enum import StrEnum

from tendond.schemas.config.servo import ServoSection


class DriverPhase(StrEnum):
    """Phase of the driver."""

    OFF = "off"
    ON = "on"
    HOLDING = "holding"
    SILENT = "silent"
    STOPPED = "stopped"
    RELEASING = "releasing tendons"
    LOST = "lost"


def next_phase(section: ServoSection, phase: DriverPhase, *, armed: bool, age: float, elapsed: float) -> DriverPhase:
    """Return the phase after one cycle without faults; what switches on or off is left to the driver.

    Args:
        section: [servo].
        phase: present.
        armed: as the newest command says.
        age: of that command [s].
        elapsed: time since the phase began [s].
    """
    lost = age > section.command_timeout
    match phase:
        case DriverPhase.ON if not armed:
            return DriverPhase.RELEASING
        case DriverPhase.ON if lost:
            return DriverPhase.HOLDING
        case DriverPhase.HOLDING if not lost:
            return DriverPhase.ON
        case DriverPhase.HOLDING if elapsed > section.hold_time:
            return DriverPhase.SILENT
        case DriverPhase.STOPPED if elapsed > section.fault_hold:
            return DriverPhase.RELEASING
    return phase
