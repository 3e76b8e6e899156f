"""State of a servo in one read, and the requests for it."""

from dataclasses import dataclass

from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.table import Register

ALERT = 0x80
"""Bit of a status packet's error byte for a hardware error."""

LAST = table.PRESENT_TEMPERATURE


@dataclass(frozen=True)
class ReadRequest:
    """Read from `address` to Present Temperature, `length` bytes."""

    address: int
    length: int


def _from(register: Register) -> ReadRequest:
    return ReadRequest(register.address, LAST.address + LAST.size - register.address)


READ_REQUESTS = tuple(map(_from, (table.TORQUE_ENABLE, table.SHUTDOWN, table.STARTUP_CONFIGURATION)))
"""Requests with all of a `ServoReading`, of different length: a reply shows to which it belongs."""


@dataclass(frozen=True)
class ServoReading:
    """State of a servo, in units of its registers; `alert`: it has a hardware error."""

    torque: int
    hardware_error: int
    watchdog: int
    goal: int
    load: int
    position: int
    voltage: int
    temperature: int
    alert: bool
    goal_pwm: int = table.FULL_PWM


def reading_from(question: ReadRequest, data: bytes, error: int) -> ServoReading:
    """Decode a reply.

    Args:
        question: request that it replies to.
        data: data of the reply, `question.length` bytes.
        error: error of the reply's status.
    """

    def value(register: Register) -> int:
        start = register.address - question.address
        return register.from_bytes(data[start : start + register.size])

    return ServoReading(
        torque=value(table.TORQUE_ENABLE),
        hardware_error=value(table.HARDWARE_ERROR_STATUS),
        watchdog=value(table.BUS_WATCHDOG),
        goal_pwm=value(table.GOAL_PWM),
        goal=value(table.GOAL_POSITION),
        load=value(table.PRESENT_LOAD),
        position=value(table.PRESENT_POSITION),
        voltage=value(table.PRESENT_INPUT_VOLTAGE),
        temperature=value(table.PRESENT_TEMPERATURE),
        alert=bool(error & ALERT),
    )
