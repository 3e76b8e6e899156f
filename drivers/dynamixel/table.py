"""The control table of the XL430-W250-T, as far as it is used: the manual's names, addresses, sizes and units."""

import math
from dataclasses import dataclass

MODEL_NUMBER = 1060
MODEL_NAME = "XL430-W250-T"


@dataclass(frozen=True)
class Register:
    """One entry: name as in the manual, address, bytes, and whether it is signed, in EEPROM or read-only.

    `least` and `most` bound what a servo accepts, in units of the register.
    """

    name: str
    address: int
    size: int
    least: int
    most: int
    initial: int = 0
    eeprom: bool = False
    read_only: bool = False

    @property
    def signed(self) -> bool:
        """Two's complement."""
        return self.least < 0

    def to_bytes(self, value: int) -> bytes:
        """Little-endian.

        Raises:
            OverflowError: the value does not fit.
        """
        return value.to_bytes(self.size, "little", signed=self.signed)

    def from_bytes(self, data: bytes) -> int:
        """The value in the register's bytes."""
        return int.from_bytes(data, "little", signed=self.signed)


_FULL = 2**31 - 1

MODEL = Register("Model Number", 0, 2, 0, 65535, MODEL_NUMBER, eeprom=True, read_only=True)
FIRMWARE = Register("Firmware Version", 6, 1, 0, 255, 46, eeprom=True, read_only=True)
ID = Register("ID", 7, 1, 0, 252, 1, eeprom=True)
BAUD_RATE = Register("Baud Rate", 8, 1, 0, 7, 1, eeprom=True)
RETURN_DELAY_TIME = Register("Return Delay Time", 9, 1, 0, 254, 250, eeprom=True)
DRIVE_MODE = Register("Drive Mode", 10, 1, 0, 13, 0, eeprom=True)
OPERATING_MODE = Register("Operating Mode", 11, 1, 0, 16, 3, eeprom=True)
HOMING_OFFSET = Register("Homing Offset", 20, 4, -1_044_479, 1_044_479, 0, eeprom=True)
TEMPERATURE_LIMIT = Register("Temperature Limit", 31, 1, 0, 100, 72, eeprom=True)
MAX_VOLTAGE_LIMIT = Register("Max Voltage Limit", 32, 2, 60, 140, 140, eeprom=True)
MIN_VOLTAGE_LIMIT = Register("Min Voltage Limit", 34, 2, 60, 140, 60, eeprom=True)
PWM_LIMIT = Register("PWM Limit", 36, 2, 0, 885, 885, eeprom=True)
VELOCITY_LIMIT = Register("Velocity Limit", 44, 4, 0, 1023, 265, eeprom=True)
STARTUP_CONFIGURATION = Register("Startup Configuration", 60, 1, 0, 3, 0, eeprom=True)
SHUTDOWN = Register("Shutdown", 63, 1, 0, 63, 0b110100, eeprom=True)
TORQUE_ENABLE = Register("Torque Enable", 64, 1, 0, 1)
LED = Register("LED", 65, 1, 0, 1)
STATUS_RETURN_LEVEL = Register("Status Return Level", 68, 1, 0, 2, 2)
HARDWARE_ERROR_STATUS = Register("Hardware Error Status", 70, 1, 0, 255, read_only=True)
BUS_WATCHDOG = Register("Bus Watchdog", 98, 1, -1, 127)
PROFILE_ACCELERATION = Register("Profile Acceleration", 108, 4, 0, 32767)
PROFILE_VELOCITY = Register("Profile Velocity", 112, 4, 0, 32767)
GOAL_POSITION = Register("Goal Position", 116, 4, -1_048_575, 1_048_575)
PRESENT_LOAD = Register("Present Load", 126, 2, -1000, 1000, read_only=True)
PRESENT_VELOCITY = Register("Present Velocity", 128, 4, -_FULL, _FULL, read_only=True)
PRESENT_POSITION = Register("Present Position", 132, 4, -_FULL, _FULL, read_only=True)
PRESENT_INPUT_VOLTAGE = Register("Present Input Voltage", 144, 2, 0, 65535, 120, read_only=True)
PRESENT_TEMPERATURE = Register("Present Temperature", 146, 1, 0, 255, 30, read_only=True)

REGISTERS = tuple(value for value in list(vars().values()) if isinstance(value, Register))
TABLE_SIZE = 147

EXTENDED_POSITION = 4
"""Of `OPERATING_MODE`: position over many turns. Power-up and a change of mode lose the turns."""

WATCHDOG_TRIPPED = -1
"""Of `BUS_WATCHDOG`: the servo has stopped by itself, and refuses goals until 0 is written."""

HARDWARE_ERRORS = {
    0: "Input Voltage Error",
    2: "Overheating Error",
    3: "Motor Encoder Error",
    4: "Electrical Shock Error",
    5: "Overload Error",
}
"""Bits of `HARDWARE_ERROR_STATUS`."""

BAUD_CODES = {9600: 0, 57600: 1, 115200: 2, 1_000_000: 3, 2_000_000: 4, 3_000_000: 5, 4_000_000: 6}

TICKS_PER_TURN = 4096
TICK = 2.0 * math.pi / TICKS_PER_TURN
"""[rad] of Goal Position and Present Position."""

VELOCITY_UNIT = 0.229 * 2.0 * math.pi / 60.0
"""[rad/s] of Profile Velocity and Present Velocity: 0.229 rpm."""

ACCELERATION_UNIT = 214.577 * 2.0 * math.pi / 3600.0
"""[rad/s^2] of Profile Acceleration: 214.577 revolutions per minute squared."""

LOAD_UNIT = 1e-3
"""Of the stall torque, in Present Load; positive towards larger positions. It is inferred from the motor's output, not
measured."""

VOLTAGE_UNIT = 0.1
"""[V]"""


def hardware_errors(value: int) -> tuple[str, ...]:
    """Names of the bits that are set, with their numbers."""
    return tuple(f"{HARDWARE_ERRORS.get(bit, 'unknown error')} (bit {bit})" for bit in range(8) if value & 1 << bit)
