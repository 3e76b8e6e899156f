"""Required register values of a servo before it moves: written by `setup`, checked by driver, doctor and tools."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import TRIES, NoReplyError, ServoBus, ServoError
from tendond.drivers.dynamixel.serial.model import ServoModel
from tendond.drivers.dynamixel.serial.models import XL430, mismatch
from tendond.drivers.dynamixel.serial.register import Register
from tendond.schemas.config.servo import ServoSection

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
        if self.register == table.RETURN_DELAY_TIME and found * table.RETURN_DELAY_UNIT <= DELAY_SHARE * reply_timeout:
            return ""
        return f"{self.register.name} is {found}, must be {self.wanted} ({self.why})"


_MODE = "goals would be speeds, or end at one turn"

_FIXED = (
    Requirement(table.DRIVE_MODE, 0, "a goal would switch the torque on, or reverse the direction, or take a time"),
    Requirement(table.STARTUP_CONFIGURATION, 0, "the torque would come on with the power"),
    Requirement(table.RETURN_DELAY_TIME, 0, "replies would come late"),
    Requirement(table.HOMING_OFFSET, 0, "the calibrated zero would be elsewhere"),
    Requirement(table.SECONDARY_ID, 255, "it would carry out commands of another servo", also=(253, 254)),
)

_FACTORY = (
    (table.SHUTDOWN, "it would not protect itself from overload, shock and heat"),
    (table.PWM_LIMIT, "it would be too weak to follow"),
    (table.CURRENT_LIMIT, "it would be too weak, or refuse its Goal Current"),
    (table.ACCELERATION_LIMIT, "it would refuse or cap its profile"),
    (table.VELOCITY_LIMIT, "it would refuse or cap its profile"),
    (table.TEMPERATURE_LIMIT, "it would not protect itself from heat"),
    (table.MAX_VOLTAGE_LIMIT, "it would not see a wrong supply"),
    (table.MIN_VOLTAGE_LIMIT, "it would not see a weak supply"),
)
"""Registers that keep the factory's value of their model, and the effect of another."""


def _requirements(model: ServoModel, mode: int) -> Iterator[Requirement]:
    yield Requirement(table.OPERATING_MODE, mode, _MODE)
    yield from (one for one in _FIXED if model.has(one.register))
    for register, why in _FACTORY:
        if model.has(register):
            yield Requirement(register, model.entry(register).initial, why)
    yield Requirement(table.STATUS_RETURN_LEVEL, 2, "it would not confirm instructions")


def requirements(model: ServoModel, section: ServoSection) -> tuple[Requirement, ...]:
    """Return the requirements for a model, in the manual's names.

    Limits are the factory's; the driver's own are in `[servo]`. With `servo.current_limit` a servo of the X series is
    in Current-based Position Control Mode; the P series limits its current in every position mode.
    """
    based = bool(section.current_limit) and table.CURRENT_POSITION in model.entry(table.OPERATING_MODE).values
    return tuple(_requirements(model, table.CURRENT_POSITION if based else table.EXTENDED_POSITION))


REQUIREMENTS = requirements(XL430, ServoSection())
"""Requirements for the default model."""


def objections(bus: ServoBus, identifier: int, section: ServoSection) -> list[str]:
    """List the wrong register values of a servo, in words; reads only.

    Raises:
        ServoError: it does not reply.
    """
    wanted = requirements(bus.model, section)
    # at once where they are close together, which EEPROM and RAM of the P series are not
    found = bus.read_many(identifier, [one.register for one in wanted if bus.model.entry(one.register).eeprom])
    found |= {table.STATUS_RETURN_LEVEL: bus.read(identifier, table.STATUS_RETURN_LEVEL)}
    wrong = [one.objection(found[one.register], section.reply_timeout) for one in wanted]
    return [objection for objection in wrong if objection]


def enable_replies(bus: ServoBus, identifiers: Iterable[int]) -> None:
    """Let servos reply to all instructions until power-down, so that they can be examined.

    Raises:
        ServoError: the packet was not sent.
    """
    bus.write_all(table.STATUS_RETURN_LEVEL, dict.fromkeys(identifiers, 2))


def model_number(bus: ServoBus, identifier: int) -> int:
    """Return a servo's Model Number, which it gives at every Status Return Level.

    Raises:
        NoReplyError: it does not reply.
    """
    for _ in range(TRIES):
        if (number := bus.ping(identifier)) is not None:
            return number
    raise NoReplyError(f"servo {identifier}: does not reply")


def require(bus: ServoBus, identifiers: Iterable[int], section: ServoSection) -> None:
    """Check the register values of servos.

    Args:
        bus: open.
        identifiers: identifiers of the servos.
        section: [servo].

    Raises:
        ServoError: one is not, with everything that is wrong and the remedy; or does not reply.
    """
    ids = tuple(identifiers)
    for identifier in ids:  # before any other register: those of another model are elsewhere
        if other := mismatch(model_number(bus, identifier), bus.model):
            raise ServoError(f"servo {identifier}: {other}")
    enable_replies(bus, ids)
    wrong = {identifier: found for identifier in ids if (found := objections(bus, identifier, section))}
    if wrong:
        raise ServoError(in_words(wrong))


def in_words(wrong: Mapping[int, list[str]]) -> str:
    """Return what is wrong with each servo, and the remedy."""
    faults = "; ".join(f"servo {identifier}: {', '.join(found)}" for identifier, found in wrong.items())
    which = " and ".join(map(str, wrong))
    return f"{faults}: run 'tendond servo setup' for {which}"
