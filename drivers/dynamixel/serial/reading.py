"""State of a servo in one read."""

from dataclasses import dataclass

from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.model import ReadRequest
from tendond.drivers.dynamixel.serial.register import Register

ALERT = 0x80
"""Bit of a status packet's error byte for a hardware error."""


@dataclass(frozen=True)
class ServoReading:
    """State of a servo, in units of its registers; `alert`: it has a hardware error.

    `load` is in `table.LOAD_UNIT` on every model, that of one that measures its current from its current. `trouble`: a
    fault in words, of a motor that is no Dynamixel.
    """

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
    goal_current: int = 0
    trouble: str = ""


def reading_from(question: ReadRequest, data: bytes, error: int) -> ServoReading:
    """Decode a reply.

    Args:
        question: request that it replies to.
        data: data of the reply, `question.length` bytes.
        error: error of the reply's status.
    """
    model = question.model

    def value(register: Register) -> int:
        entry = model.entry(register)
        start = entry.address - question.address
        return entry.from_bytes(data[start : start + entry.size])

    return ServoReading(
        torque=value(table.TORQUE_ENABLE),
        hardware_error=value(table.HARDWARE_ERROR_STATUS),
        watchdog=value(table.BUS_WATCHDOG),
        goal_pwm=value(table.GOAL_PWM),
        goal_current=value(table.GOAL_CURRENT) if model.current_unit else 0,
        goal=value(table.GOAL_POSITION),
        load=round(value(model.load) * model.load_unit / table.LOAD_UNIT),
        position=value(table.PRESENT_POSITION),
        voltage=value(table.PRESENT_INPUT_VOLTAGE),
        temperature=value(table.PRESENT_TEMPERATURE),
        alert=bool(error & ALERT),
    )
