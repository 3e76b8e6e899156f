"""What a servo must be before anything moves it: one list, written by `setup`, asked by driver, doctor and tools."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import ServoBus, ServoError
from tendond.drivers.dynamixel.serial.table import Register

DELAY_SHARE = 0.25
"""Of `servo.answer_timeout`, that a Return Delay Time may take."""


@dataclass(frozen=True)
class Requirement:
    """One register.

    Attributes:
        register: of the control table.
        wanted: value that `setup` writes.
        why: what another value does.
        also: other values that do as well.
    """

    register: Register
    wanted: int
    why: str
    also: tuple[int, ...] = ()

    def objection(self, found: int, answer_timeout: float) -> str:
        """What is wrong with a value, in words; empty if nothing."""
        if found == self.wanted or found in self.also:
            return ""
        if self.register is table.RETURN_DELAY_TIME and found * table.RETURN_DELAY_UNIT <= DELAY_SHARE * answer_timeout:
            return ""
        return f"{self.register.name} is {found}, must be {self.wanted} ({self.why})"


REQUIREMENTS = (
    Requirement(table.OPERATING_MODE, table.EXTENDED_POSITION, "goals would be speeds, or end at one turn"),
    Requirement(table.DRIVE_MODE, 0, "a goal would switch the torque on, or turn the other way, or take a time"),
    Requirement(table.STARTUP_CONFIGURATION, 0, "the torque would come on with the power"),
    Requirement(table.RETURN_DELAY_TIME, 0, "answers would come late"),
    Requirement(table.HOMING_OFFSET, 0, "the calibrated zero would be elsewhere"),
    Requirement(table.SECONDARY_ID, 255, "it would do what another servo is told", also=(253, 254)),
    Requirement(table.SHUTDOWN, table.SHUTDOWN.initial, "it would not protect itself from overload, shock and heat"),
    Requirement(table.PWM_LIMIT, table.PWM_LIMIT.initial, "it would be too weak to follow"),
    Requirement(table.VELOCITY_LIMIT, table.VELOCITY_LIMIT.initial, "it would refuse or cap its profile"),
    Requirement(table.TEMPERATURE_LIMIT, table.TEMPERATURE_LIMIT.initial, "it would not protect itself from heat"),
    Requirement(table.MAX_VOLTAGE_LIMIT, table.MAX_VOLTAGE_LIMIT.initial, "it would not see a wrong supply"),
    Requirement(table.MIN_VOLTAGE_LIMIT, table.MIN_VOLTAGE_LIMIT.initial, "it would not see a weak supply"),
    Requirement(table.STATUS_RETURN_LEVEL, 2, "it would not confirm what it is told"),
)
"""In the manual's names. Limits are those of the factory: what the driver allows is bounded in `[servo]`."""


def objections(bus: ServoBus, identifier: int, answer_timeout: float) -> list[str]:
    """What a servo is that it must not be, in words; asks only.

    Raises:
        ServoError: it does not answer.
    """
    found = bus.read_many(identifier, [one.register for one in REQUIREMENTS])
    wrong = [one.objection(found[one.register], answer_timeout) for one in REQUIREMENTS]
    return [objection for objection in wrong if objection]


def let_answer(bus: ServoBus, identifiers: Iterable[int]) -> None:
    """Have servos answer everything until their power goes: one that does not cannot be asked why.

    Raises:
        ServoError: the packet did not go out.
    """
    bus.write_all(table.STATUS_RETURN_LEVEL, dict.fromkeys(identifiers, 2))


def require(bus: ServoBus, identifiers: Iterable[int], answer_timeout: float) -> None:
    """See that servos are what they must be.

    Args:
        bus: open.
        identifiers: of the servos.
        answer_timeout: of [servo] [s].

    Raises:
        ServoError: one is not, with everything that is wrong and the remedy; or does not answer.
    """
    ids = tuple(identifiers)
    let_answer(bus, ids)
    wrong: dict[int, list[str]] = {}
    for identifier in ids:
        model = bus.read(identifier, table.MODEL)
        if model != table.MODEL_NUMBER:
            wrong[identifier] = [f"is model {model}, not {table.MODEL_NUMBER} ({table.MODEL_NAME})"]
        elif found := objections(bus, identifier, answer_timeout):
            wrong[identifier] = found
    if wrong:
        raise ServoError(in_words(wrong))


def in_words(wrong: Mapping[int, list[str]]) -> str:
    """What is wrong with which servo, and the remedy."""
    said = "; ".join(f"servo {identifier}: {', '.join(found)}" for identifier, found in wrong.items())
    which = " and ".join(map(str, wrong))
    return f"{said}: run 'tendond servo setup' for {which}"
