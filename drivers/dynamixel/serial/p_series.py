"""Control tables of the P series as data: the manual's names, addresses, sizes, ranges and initial values.

Source: ROBOTIS e-Manual, PH42-020-S300-R and PH54-100-S500-R (`/docs/en/dxl/p/MODEL/`), "Control Table of EEPROM Area"
and "Control Table of RAM Area"; Baud Rate(8), Goal PWM(548), Goal Position(564). Gains have no initial value there, and
none here.
"""

import math
from typing import Any

from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.model import ServoModel
from tendond.drivers.dynamixel.serial.register import Register
from tendond.drivers.dynamixel.serial.x_series import indirect
from tendond.schemas.motors import MOTORS

_FULL = 2**31 - 1
_GAIN = 32_767
_VELOCITY = 2920
_PWM = 2009

VELOCITY_UNIT = 0.01 * 2.0 * math.pi / 60.0
"""Unit of Profile, Goal and Present Velocity [rad/s]: 0.01 rev/min."""

ACCELERATION_UNIT = 2.0 * math.pi / 3600.0
"""Unit of Profile Acceleration [rad/s^2]: 1 revolution per minute squared."""

MILLIAMPERE = 1e-3
"""Unit of currents [A]."""

BAUD_CODES = table.BAUD_CODES | {6_000_000: 8, 10_500_000: 9}


def _eeprom(name: str, address: int, size: int, low: int, high: int, initial: int = 0, **more: Any) -> Register:
    return Register(name, address, size, low, high, initial, eeprom=True, **more)


def _read(name: str, address: int, size: int, low: int, high: int, initial: int = 0) -> Register:
    return Register(name, address, size, low, high, initial, read_only=True)


def _registers(
    number: int, current: int, acceleration: tuple[int, int], position: tuple[int, int]
) -> tuple[Register, ...]:
    """Return a model's table.

    Args:
        number: Model Number.
        current: Current Limit [1 mA].
        acceleration: Acceleration Limit, initial and largest value [1 rev/min^2].
        position: Max Position Limit, initial and largest value; those of Min Position Limit are their negatives.
    """
    limit, furthest = position
    return (
        _eeprom("Model Number", 0, 2, 0, 65535, number, read_only=True),
        _eeprom("Model Information", 2, 4, 0, 2**32 - 1, read_only=True),
        _eeprom("Firmware Version", 6, 1, 0, 255, 12, read_only=True),
        _eeprom("ID", 7, 1, 0, 252, 1),
        _eeprom("Baud Rate", 8, 1, 0, 9, 1),
        _eeprom("Return Delay Time", 9, 1, 0, 254, 250),
        _eeprom("Drive Mode", 10, 1, 0, 1),
        _eeprom("Operating Mode", 11, 1, 0, 16, 3, values=(0, 1, 3, 4, 16)),
        _eeprom("Secondary(Shadow) ID", 12, 1, 0, 255, 255),
        _eeprom("Protocol Type", 13, 1, 2, 10, 2, values=(2, 10)),
        _eeprom("Homing Offset", 20, 4, -_FULL - 1, _FULL),
        _eeprom("Moving Threshold", 24, 4, 0, _VELOCITY, 20),
        _eeprom("Temperature Limit", 31, 1, 0, 100, 80),
        _eeprom("Max Voltage Limit", 32, 2, 150, 350, 350),
        _eeprom("Min Voltage Limit", 34, 2, 150, 350, 150),
        _eeprom("PWM Limit", 36, 2, 0, _PWM, _PWM),
        _eeprom("Current Limit", 38, 2, 0, current, current),
        _eeprom("Acceleration Limit", 40, 4, 0, acceleration[1], acceleration[0]),
        _eeprom("Velocity Limit", 44, 4, 0, _VELOCITY, _VELOCITY),
        _eeprom("Max Position Limit", 48, 4, -furthest, furthest, limit),
        _eeprom("Min Position Limit", 52, 4, -furthest, furthest, -limit),
        *(_eeprom(f"External Port Mode {n}", 55 + n, 1, 0, 3, 3) for n in range(1, 5)),
        _eeprom("Shutdown", 63, 1, 0, 255, 58),
        Register("Torque Enable", 512, 1, 0, 1),
        *(Register(f"LED {colour}", 513 + n, 1, 0, 255) for n, colour in enumerate(("Red", "Green", "Blue"))),
        Register("Status Return Level", 516, 1, 0, 2, 2),
        _read("Registered Instruction", 517, 1, 0, 1),
        _read("Hardware Error Status", 518, 1, 0, 255),
        Register("Velocity I Gain", 524, 2, 0, _GAIN),
        Register("Velocity P Gain", 526, 2, 0, _GAIN),
        Register("Position D Gain", 528, 2, 0, _GAIN),
        Register("Position I Gain", 530, 2, 0, _GAIN),
        Register("Position P Gain", 532, 2, 0, _GAIN),
        Register("Feedforward 2nd Gain", 536, 2, 0, _GAIN),
        Register("Feedforward 1st Gain", 538, 2, 0, _GAIN),
        Register("Bus Watchdog", 546, 1, -1, 127, values=tuple(range(128))),
        Register("Goal PWM", 548, 2, -_PWM, _PWM, _PWM),
        Register("Goal Current", 550, 2, -current, current, current),
        Register("Goal Velocity", 552, 4, -_VELOCITY, _VELOCITY),
        Register("Profile Acceleration", 556, 4, 0, acceleration[1]),
        Register("Profile Velocity", 560, 4, 0, _VELOCITY),
        Register("Goal Position", 564, 4, -_FULL - 1, _FULL),
        _read("Realtime Tick", 568, 2, 0, 32767),
        _read("Moving", 570, 1, 0, 1),
        _read("Moving Status", 571, 1, 0, 255),
        _read("Present PWM", 572, 2, -_PWM, _PWM),
        _read("Present Current", 574, 2, -32768, 32767),
        _read("Present Velocity", 576, 4, -_FULL, _FULL),
        _read("Present Position", 580, 4, -_FULL, _FULL),
        _read("Velocity Trajectory", 584, 4, -_FULL, _FULL),
        _read("Position Trajectory", 588, 4, -_FULL, _FULL),
        _read("Present Input Voltage", 592, 2, 0, 65535, 240),
        _read("Present Temperature", 594, 1, 0, 255, 30),
        *(Register(f"External Port Data {n}", 598 + 2 * n, 2, 0, 4095) for n in range(1, 5)),
        *indirect(((1, 128, 168, 634),), 512, 1023),
    )


def _model(name: str, acceleration: int, position: tuple[int, int]) -> ServoModel:
    motor = MOTORS[name]
    initial = round(motor.acceleration_limit / ACCELERATION_UNIT)
    return ServoModel(
        motor=motor,
        registers=_registers(motor.number, round(motor.current_max / MILLIAMPERE), (initial, acceleration), position),
        velocity_unit=VELOCITY_UNIT,
        acceleration_unit=ACCELERATION_UNIT,
        full_pwm=_PWM,
        current_unit=MILLIAMPERE,
        baud_codes=BAUD_CODES,
        reads=tuple(
            ("Torque Enable", last) for last in ("Present Temperature", "External Port Data 1", "External Port Data 2")
        ),
        clears_profile=False,
        centred=True,
    )


MODELS = (
    _model("PH42-020-S300", 4_306_173, (303_454, 303_750)),
    _model("PH54-100-S500", 4_255_632, (501_433, 501_923)),
)
