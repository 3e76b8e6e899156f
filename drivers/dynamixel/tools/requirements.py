"""Required register values of a servo before it moves: written by `setup`, checked by driver, doctor and tools."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import ServoBus, ServoError
from tendond.drivers.dynamixel.serial.table import Register

DELAY_SHARE = 0.25
"""Largest Return Delay Time, as a fraction of `servo.reply_timeout`."""


@dataclass(frozen=True)
class Requirement:
    """Required value of one register.

    Attributes:
        register: register of the control table.
        wanted: value that `setup` writes.
        why: effect of another value.
        also: other allowed values.
    """

    register: Register
    wanted: int
    why: str
    also: tuple[int, ...] = ()

    def objection(self, found: int, reply_timeout: float) -> str:
        """Return what is wrong with a value, in words; empty for a valid one."""
        if found == self.wanted or found in self.also:
            return ""
        if self.register is table.RETURN_DELAY_TIME and found * table.RETURN_DELAY_UNIT <= DELAY_SHARE * reply_timeout:
            return ""
        return f"{self.register.name} is {found}, must be {self.wanted} ({self.why})"


REQUIREMENTS = (
    Requirement(table.OPERATING_MODE, table.EXTENDED_POSITION, "goals would be speeds, or end at one turn"),
    Requirement(table.DRIVE_MODE, 0, "a goal would switch the torque on, or reverse the direction, or take a time"),
    Requirement(table.STARTUP_CONFIGURATION, 0, "the torque would come on with the power"),
    Requirement(table.RETURN_DELAY_TIME, 0, "replies would come late"),
    Requirement(table.HOMING_OFFSET, 0, "the calibrated zero would be elsewhere"),
    Requirement(table.SECONDARY_ID, 255, "it would carry out commands of another servo", also=(253, 254)),
    Requirement(table.SHUTDOWN, table.SHUTDOWN.initial, "it would not protect itself from overload, shock and heat"),
    Requirement(table.PWM_LIMIT, table.PWM_LIMIT.initial, "it would be too weak to follow"),
    Requirement(table.VELOCITY_LIMIT, table.VELOCITY_LIMIT.initial, "it would refuse or cap its profile"),
    Requirement(table.TEMPERATURE_LIMIT, table.TEMPERATURE_LIMIT.initial, "it would not protect itself from heat"),
    Requirement(table.MAX_VOLTAGE_LIMIT, table.MAX_VOLTAGE_LIMIT.initial, "it would not see a wrong supply"),
    Requirement(table.MIN_VOLTAGE_LIMIT, table.MIN_VOLTAGE_LIMIT.initial, "it would not see a weak supply"),
    Requirement(table.STATUS_RETURN_LEVEL, 2, "it would not confirm instructions"),
)
"""Requirements, in the manual's names. Limits are the factory's; the driver's own are in `[servo]`."""


def objections(bus: ServoBus, identifier: int, reply_timeout: float) -> list[str]:
    """List the wrong register values of a servo, in words; reads only.

    Raises:
        ServoError: it does not reply.
    """
    found = bus.read_many(identifier, [one.register for one in REQUIREMENTS])
    wrong = [one.objection(found[one.register], reply_timeout) for one in REQUIREMENTS]
    return [objection for objection in wrong if objection]


def enable_replies(bus: ServoBus, identifiers: Iterable[int]) -> None:
    """Let servos reply to all instructions until power-down, so that they can be examined.

    Raises:
        ServoError: the packet was not sent.
    """
    bus.write_all(table.STATUS_RETURN_LEVEL, dict.fromkeys(identifiers, 2))


def require(bus: ServoBus, identifiers: Iterable[int], reply_timeout: float) -> None:
    """Check the register values of servos.

    Args:
        bus: open.
        identifiers: identifiers of the servos.
        reply_timeout: reply timeout of [servo] [s].

    Raises:
        ServoError: one is not, with everything that is wrong and the remedy; or does not reply.
    """
    ids = tuple(identifiers)
    enable_replies(bus, ids)
    wrong: dict[int, list[str]] = {}
    for identifier in ids:
        model = bus.read(identifier, table.MODEL)
        if model != table.MODEL_NUMBER:
            wrong[identifier] = [f"is model {model}, not {table.MODEL_NUMBER} ({table.MODEL_NAME})"]
        elif found := objections(bus, identifier, reply_timeout):
            wrong[identifier] = found
    if wrong:
        raise ServoError(in_words(wrong))


def in_words(wrong: Mapping[int, list[str]]) -> str:
    """Return what is wrong with each servo, and the remedy."""
    faults = "; ".join(f"servo {identifier}: {', '.join(found)}" for identifier, found in wrong.items())
    which = " and ".join(map(str, wrong))
    return f"{faults}: run 'tendond servo setup' for {which}"
