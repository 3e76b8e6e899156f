"""Control table of the XL430-W250-T as data: the manual's names, addresses, sizes, ranges and initial values.

Its registers are also how the code names one on any model: the entry of the model's own table has the same name
(`models.py:ServoModel.entry`).

Source: ROBOTIS e-Manual, XL430-W250-T, "Control Table of EEPROM Area" and "Control Table of RAM Area".
"""

import math

from tendond.drivers.dynamixel.serial.register import Register
from tendond.schemas.motors import XL430_W250

MODEL_NUMBER = XL430_W250.number
MODEL_NAME = XL430_W250.name

_FULL = 2**31 - 1
_GAIN = 16_383

MODEL = Register("Model Number", 0, 2, 0, 65535, MODEL_NUMBER, eeprom=True, read_only=True)
MODEL_INFORMATION = Register("Model Information", 2, 4, 0, 2**32 - 1, 0, eeprom=True, read_only=True)
FIRMWARE = Register("Firmware Version", 6, 1, 0, 255, 46, eeprom=True, read_only=True)
ID = Register("ID", 7, 1, 0, 252, 1, eeprom=True)
BAUD_RATE = Register("Baud Rate", 8, 1, 0, 7, 1, eeprom=True)
RETURN_DELAY_TIME = Register("Return Delay Time", 9, 1, 0, 254, 250, eeprom=True)
DRIVE_MODE = Register("Drive Mode", 10, 1, 0, 13, 0, eeprom=True, bits=0b1101)
OPERATING_MODE = Register("Operating Mode", 11, 1, 0, 16, 3, eeprom=True, values=(1, 3, 4, 16))
SECONDARY_ID = Register("Secondary(Shadow) ID", 12, 1, 0, 255, 255, eeprom=True)
PROTOCOL_TYPE = Register("Protocol Type", 13, 1, 1, 2, 2, eeprom=True)
HOMING_OFFSET = Register("Homing Offset", 20, 4, -1_044_479, 1_044_479, 0, eeprom=True)
MOVING_THRESHOLD = Register("Moving Threshold", 24, 4, 0, 1023, 10, eeprom=True)
TEMPERATURE_LIMIT = Register("Temperature Limit", 31, 1, 0, 100, 72, eeprom=True)
MAX_VOLTAGE_LIMIT = Register("Max Voltage Limit", 32, 2, 60, 140, 140, eeprom=True)
MIN_VOLTAGE_LIMIT = Register("Min Voltage Limit", 34, 2, 60, 140, 60, eeprom=True)
PWM_LIMIT = Register("PWM Limit", 36, 2, 0, 885, 885, eeprom=True)
VELOCITY_LIMIT = Register("Velocity Limit", 44, 4, 0, 1023, 265, eeprom=True)
MAX_POSITION_LIMIT = Register("Max Position Limit", 48, 4, 0, 4095, 4095, eeprom=True)
MIN_POSITION_LIMIT = Register("Min Position Limit", 52, 4, 0, 4095, 0, eeprom=True)
STARTUP_CONFIGURATION = Register("Startup Configuration", 60, 1, 0, 3, 0, eeprom=True)
SHUTDOWN = Register("Shutdown", 63, 1, 0, 63, 52, eeprom=True, bits=0b111101)
TORQUE_ENABLE = Register("Torque Enable", 64, 1, 0, 1)
LED = Register("LED", 65, 1, 0, 1)
STATUS_RETURN_LEVEL = Register("Status Return Level", 68, 1, 0, 2, 2)
REGISTERED_INSTRUCTION = Register("Registered Instruction", 69, 1, 0, 1, read_only=True)
HARDWARE_ERROR_STATUS = Register("Hardware Error Status", 70, 1, 0, 255, read_only=True)
VELOCITY_I_GAIN = Register("Velocity I Gain", 76, 2, 0, _GAIN, 1000)
VELOCITY_P_GAIN = Register("Velocity P Gain", 78, 2, 0, _GAIN, 100)
POSITION_D_GAIN = Register("Position D Gain", 80, 2, 0, _GAIN, 4000)
POSITION_I_GAIN = Register("Position I Gain", 82, 2, 0, _GAIN, 0)
POSITION_P_GAIN = Register("Position P Gain", 84, 2, 0, _GAIN, 640)
FEEDFORWARD_2ND_GAIN = Register("Feedforward 2nd Gain", 88, 2, 0, _GAIN, 0)
FEEDFORWARD_1ST_GAIN = Register("Feedforward 1st Gain", 90, 2, 0, _GAIN, 0)
BUS_WATCHDOG = Register("Bus Watchdog", 98, 1, -1, 127, values=tuple(range(128)))
GOAL_PWM = Register("Goal PWM", 100, 2, -885, 885, 885)
GOAL_VELOCITY = Register("Goal Velocity", 104, 4, -1023, 1023)
PROFILE_ACCELERATION = Register("Profile Acceleration", 108, 4, 0, 32767)
PROFILE_VELOCITY = Register("Profile Velocity", 112, 4, 0, 32767)
GOAL_POSITION = Register("Goal Position", 116, 4, -1_048_575, 1_048_575)
REALTIME_TICK = Register("Realtime Tick", 120, 2, 0, 32767, read_only=True)
MOVING = Register("Moving", 122, 1, 0, 1, read_only=True)
MOVING_STATUS = Register("Moving Status", 123, 1, 0, 255, read_only=True)
PRESENT_PWM = Register("Present PWM", 124, 2, -885, 885, read_only=True)
PRESENT_LOAD = Register("Present Load", 126, 2, -1000, 1000, read_only=True)
PRESENT_VELOCITY = Register("Present Velocity", 128, 4, -_FULL, _FULL, read_only=True)
PRESENT_POSITION = Register("Present Position", 132, 4, -_FULL, _FULL, read_only=True)
VELOCITY_TRAJECTORY = Register("Velocity Trajectory", 136, 4, -_FULL, _FULL, read_only=True)
POSITION_TRAJECTORY = Register("Position Trajectory", 140, 4, -_FULL, _FULL, read_only=True)
PRESENT_INPUT_VOLTAGE = Register("Present Input Voltage", 144, 2, 0, 65535, 120, read_only=True)
PRESENT_TEMPERATURE = Register("Present Temperature", 146, 1, 0, 255, 30, read_only=True)
BACKUP_READY = Register("Backup Ready", 147, 1, 0, 1, read_only=True)

INDIRECT_FIRST, INDIRECT_LAST = 64, 661
"""Addresses that an Indirect Address may name."""

INDIRECT_BLOCKS = ((1, 28, 168, 224), (29, 56, 578, 634))
"""First and last number, address of the first Indirect Address, and of the first Indirect Data."""

INDIRECT_ADDRESSES = tuple(
    Register(f"Indirect Address {n}", at + 2 * (n - first), 2, INDIRECT_FIRST, INDIRECT_LAST, data + n - first)
    for first, last, at, data in INDIRECT_BLOCKS
    for n in range(first, last + 1)
)
INDIRECT_DATA = tuple(
    Register(f"Indirect Data {n}", data + n - first, 1, 0, 255)
    for first, last, _, data in INDIRECT_BLOCKS
    for n in range(first, last + 1)
)

REGISTERS = (
    *(value for value in list(vars().values()) if isinstance(value, Register)),
    *INDIRECT_ADDRESSES,
    *INDIRECT_DATA,
)
TABLE_SIZE = 662

CURRENT_LIMIT = Register("Current Limit", 38, 2, 0, 1193, 1193, eeprom=True)
ACCELERATION_LIMIT = Register("Acceleration Limit", 40, 4, 0, 32767, 32767, eeprom=True)
PWM_SLOPE = Register("PWM Slope", 62, 1, 1, 255, 140, eeprom=True)
GOAL_CURRENT = Register("Goal Current", 102, 2, -1193, 1193, 1193)
PRESENT_CURRENT = Register("Present Current", 126, 2, -32768, 32767, read_only=True)
"""Registers of other models, which the XL430 has not."""

EXTENDED_POSITION = 4
"""Value of `OPERATING_MODE`: position over many turns. Power-up and a change of mode lose the turns."""

POSITION = 3
"""Value of `OPERATING_MODE`: within one turn, between the position limits."""

CURRENT_POSITION = 5
"""Value of `OPERATING_MODE`: position over many turns, with a current of at most `GOAL_CURRENT`."""

TORQUE_ON_BY_GOAL, TIME_BASED, REVERSE = 0b1000, 0b0100, 0b0001
"""Bits of `DRIVE_MODE`."""

FULL_PWM = 885
"""Value of `PWM_LIMIT`, `GOAL_PWM` and `PRESENT_PWM` for the whole supply voltage."""

WATCHDOG_TRIPPED = -1
"""Value of `BUS_WATCHDOG`: the servo has stopped by itself, and refuses goals until 0 is written."""

VOLTAGE_ERROR, HOT_ERROR, OVERLOAD_ERROR = 0, 2, 5

HARDWARE_ERRORS = {
    VOLTAGE_ERROR: "Input Voltage Error",
    1: "Motor Hall Sensor Error",
    HOT_ERROR: "Overheating Error",
    3: "Motor Encoder Error",
    4: "Electrical Shock Error",
    OVERLOAD_ERROR: "Overload Error",
}
"""Bits of `HARDWARE_ERROR_STATUS`; the X series never sets bit 1, which is of the P series."""

BAUD_CODES = {
    9600: 0,
    57600: 1,
    115200: 2,
    1_000_000: 3,
    2_000_000: 4,
    3_000_000: 5,
    4_000_000: 6,
    4_500_000: 7,
}

TICKS_PER_TURN = 4096
TICK = 2.0 * math.pi / TICKS_PER_TURN
"""Unit of Goal Position and Present Position [rad]."""

VELOCITY_UNIT = 0.229 * 2.0 * math.pi / 60.0
"""Unit of Profile Velocity and Present Velocity [rad/s]: 0.229 rpm."""

ACCELERATION_UNIT = 214.577 * 2.0 * math.pi / 3600.0
"""Unit of Profile Acceleration [rad/s^2]: 214.577 revolutions per minute squared."""

RETURN_DELAY_UNIT = 2e-6
"""Unit of Return Delay Time [s]."""

LOAD_UNIT = 1e-3
"""Unit of Present Load, as a fraction of the stall torque [-]; positive towards larger positions. The servo infers the
load from the motor's output."""

VOLTAGE_UNIT = 0.1
"""Unit of Present Input Voltage [V]."""


def hardware_errors(value: int) -> tuple[str, ...]:
    """Return the names of the bits that are set, with their numbers."""
    return tuple(f"{HARDWARE_ERRORS.get(bit, 'unknown error')} (bit {bit})" for bit in range(8) if value & 1 << bit)
