"""Control tables of the X series as data: what differs from the XL430's, which is in `table.py`.

Source: ROBOTIS e-Manual, the page of each model (`/docs/en/dxl/x/MODEL/`), "Control Table of EEPROM Area" and "Control
Table of RAM Area"; the rates of the 330s: Baud Rate(8); bits of Shutdown(63). A model's row has its initial values of
Velocity and Position Gains, limits and units where they differ.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.model import ServoModel
from tendond.drivers.dynamixel.serial.register import Register
from tendond.schemas.motors import MOTORS

READS = tuple((first, "Present Temperature") for first in ("Torque Enable", "Shutdown", "Startup Configuration"))

CURRENT_MODES = (0, 1, 3, 4, 5, 16)

INDIRECT_330 = ((1, 20, 168, 208),)
"""First and last number, address of the first Indirect Address, and of the first Indirect Data."""


def indirect(blocks: tuple[tuple[int, int, int, int], ...], lowest: int, highest: int) -> tuple[Register, ...]:
    """Return the registers of Indirect Addresses and Data; an address may name bytes from `lowest` to `highest`."""
    registers = [
        Register(f"Indirect Address {n}", at + 2 * (n - first), 2, lowest, highest, data + n - first)
        for first, last, at, data in blocks
        for n in range(first, last + 1)
    ]
    registers += [
        Register(f"Indirect Data {n}", data + n - first, 1, 0, 255)
        for first, last, _, data in blocks
        for n in range(first, last + 1)
    ]
    return tuple(registers)


def _registers(changes: Mapping[str, Mapping[str, Any]], current: int, small: bool) -> Iterator[Register]:
    """Yield a model's registers: those of the XL430 with other figures, and those of its current.

    Args:
        changes: figures by the register's name.
        current: Current Limit [units]; 0 without a measured current.
        small: one of the 330s, with fewer Indirect Addresses, and PWM Slope.
    """
    for register in table.REGISTERS:
        if register.name.startswith("Indirect ") and small:
            continue
        if register == table.PRESENT_LOAD and current:
            yield table.PRESENT_CURRENT
            continue
        yield replace(register, **changes.get(register.name, {}))
    if current:
        yield replace(table.CURRENT_LIMIT, maximum=current, initial=current)
        yield replace(table.GOAL_CURRENT, minimum=-current, maximum=current, initial=current)
    if small:
        yield replace(table.PWM_SLOPE, **changes.get("PWM Slope", {}))
        yield from indirect(INDIRECT_330, 64, 227)


def _model(
    name: str,
    *,
    volts: tuple[int, int],
    gains: tuple[int, int, int, int, int],
    current: int = 0,
    current_unit: float = 0.0,
    small: bool = False,
    shutdown: int = 52,
    moving: int = 10,
    drive: int = 0b0101,
    slope: int = 140,
) -> ServoModel:
    """Make a model from its row.

    Args:
        name: as in `servo.model`.
        volts: Min and Max Voltage Limit [0.1 V], which are also their range.
        gains: Velocity I and P, Position D, I and P Gain.
        current: Current Limit [units of `current_unit`].
        current_unit: [A].
        small: one of the 330s.
        shutdown, moving, slope: initial values of Shutdown, Moving Threshold, PWM Slope.
        drive: bits of Drive Mode.
    """
    motor = MOTORS[name]
    velocity = 2047 if small else 1023
    low, high = volts
    lowest = 31 if small and high == 70 else low
    names = ("Velocity I Gain", "Velocity P Gain", "Position D Gain", "Position I Gain", "Position P Gain")
    changes: dict[str, dict[str, object]] = {
        "Model Number": {"initial": motor.number},
        "Drive Mode": {"maximum": drive, "bits": drive},
        "Operating Mode": {"values": CURRENT_MODES if current else (1, 3, 4, 16)},
        "Moving Threshold": {"initial": moving},
        "Temperature Limit": {"initial": round(motor.temperature_limit)},
        "Max Voltage Limit": {"minimum": lowest, "maximum": high, "initial": high},
        "Min Voltage Limit": {"minimum": lowest, "maximum": high, "initial": low},
        "Velocity Limit": {"maximum": velocity, "initial": round(motor.velocity_limit / table.VELOCITY_UNIT)},
        "Goal Velocity": {"minimum": -velocity, "maximum": velocity},
        "Shutdown": {"initial": shutdown},
        "PWM Slope": {"initial": slope},
        **{name: {"initial": gain} for name, gain in zip(names, gains, strict=True)},
    }
    rates = dict(table.BAUD_CODES)
    if small:
        changes |= {
            "Baud Rate": {"maximum": 6},
            "Protocol Type": {"minimum": 2, "maximum": 22, "values": (2, 20, 21, 22)},
        }
        del rates[4_500_000]
    return ServoModel(
        motor=motor,
        registers=tuple(_registers(changes, current, small)),
        velocity_unit=table.VELOCITY_UNIT,
        acceleration_unit=table.ACCELERATION_UNIT,
        full_pwm=table.FULL_PWM,
        current_unit=current_unit,
        baud_codes=rates,
        reads=READS,
        clears_profile=True,
        centred=False,
    )


XL430 = ServoModel(
    motor=MOTORS[table.MODEL_NAME],
    registers=table.REGISTERS,
    velocity_unit=table.VELOCITY_UNIT,
    acceleration_unit=table.ACCELERATION_UNIT,
    full_pwm=table.FULL_PWM,
    current_unit=0.0,
    baud_codes=table.BAUD_CODES,
    reads=READS,
    clears_profile=True,
    centred=False,
)

MILLIAMPERE, X_CURRENT = 1e-3, 2.69e-3
"""Units of Present Current, Goal Current and Current Limit [A]: of the 330s, and of the larger ones."""

XM = (1920, 100, 0, 0, 800)
"""Gains of the XM series."""

MODELS = (
    XL430,
    _model(
        "XL330-M077",
        volts=(35, 70),
        gains=(400, 40, 0, 400, 400),
        current=1750,
        current_unit=MILLIAMPERE,
        small=True,
        shutdown=53,
    ),
    _model(
        "XL330-M288",
        volts=(35, 70),
        gains=(1600, 180, 0, 0, 400),
        current=1750,
        current_unit=MILLIAMPERE,
        small=True,
        shutdown=53,
    ),
    _model(
        "XC330-M288",
        volts=(35, 70),
        gains=(1600, 50, 500, 0, 1100),
        current=2352,
        current_unit=MILLIAMPERE,
        small=True,
    ),
    _model(
        "XC330-T288",
        volts=(55, 140),
        gains=(1200, 40, 0, 0, 900),
        current=910,
        current_unit=MILLIAMPERE,
        small=True,
        slope=255,
    ),
    _model("XC430-W150", volts=(60, 160), gains=(1920, 100, 0, 0, 460), moving=20),
    _model("XC430-W240", volts=(60, 160), gains=(1920, 100, 0, 0, 700), drive=0b1101),
    _model("XM430-W210", volts=(95, 160), gains=XM, current=1193, current_unit=X_CURRENT),
    _model("XM430-W350", volts=(95, 160), gains=XM, current=1193, current_unit=X_CURRENT),
    _model("XM540-W150", volts=(95, 160), gains=XM, current=2047, current_unit=X_CURRENT),
    _model("XM540-W270", volts=(95, 160), gains=XM, current=2047, current_unit=X_CURRENT),
)
