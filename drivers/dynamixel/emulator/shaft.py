"""Shaft of an emulated servo and its sensors: turns counted, positions and measurements reported in registers."""

import math

from tendond.drivers.dynamixel.emulator.control_table import ControlTable
from tendond.drivers.dynamixel.emulator.motion import Actuator
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.model import ServoModel
from tendond.drivers.dynamixel.serial.register import Register

SUPPLY_VOLTS = 12.0
"""Supply at power-up, where a model has that [V]; others have their rated one."""

TICK_WRAP = 32768
"""Number of values of Realtime Tick, which counts milliseconds."""


class EmulatedShaft:
    """Shaft with the control table that reports it.

    Args:
        position: position of the shaft at power-up [ticks]; the servo knows only the position within a turn.
        model: of the servo.

    Attributes:
        model: of the servo.
        temperature: [degree Celsius]. voltage: [V].
    """

    def __init__(self, position: int, model: ServoModel) -> None:
        self.model = model
        self._memory = ControlTable(model)
        self.temperature = 30.0
        low, high = model.motor.voltage
        self.voltage = SUPPLY_VOLTS if low <= SUPPLY_VOLTS <= high else model.motor.rated_volts
        self._shaft = Actuator()
        self._shaft.place(float(position))
        self._milliseconds = 0.0
        self._ongoing = False
        self._forget_turns()

    def value(self, register: Register) -> int:
        """Return the value of a register."""
        return self._memory.value(register)

    def _store(self, register: Register, value: int) -> None:
        self._memory.store(register, value)

    @property
    def position(self) -> float:
        """Position of the shaft with all its turns, also those that the servo has lost [ticks]."""
        return self._shaft.shaft

    @property
    def energised(self) -> bool:
        """True while the torque is on."""
        return bool(self.value(table.TORQUE_ENABLE))

    def count_turns(self, turns: int) -> None:
        """Add whole turns to the count, as if the shaft had turned."""
        self._turns += turns
        self._measure()
        if self.energised:
            self._hold()

    def _forget_turns(self) -> None:
        """Reduce the position to one within a single turn."""
        half = 0.5 if self.model.centred else 0.0
        self._turns = -math.floor(self._shaft.shaft / self.model.motor.ticks_per_turn + half)

    @property
    def _direction(self) -> int:
        return -1 if self.value(table.DRIVE_MODE) & table.REVERSE else 1

    def _reported(self, shaft: float) -> int:
        """Return the Present Position for a position of the shaft [ticks]."""
        counted = shaft + self._turns * self.model.motor.ticks_per_turn
        return round(self._direction * counted) + self.value(table.HOMING_OFFSET)

    def _shaft_at(self, goal: int) -> float:
        """Return the position of the shaft for a Goal Position [ticks]."""
        counted = self._direction * (goal - self.value(table.HOMING_OFFSET))
        return float(counted - self._turns * self.model.motor.ticks_per_turn)

    def _hold(self) -> None:
        """Stop at the present position."""
        self._shaft.place(self._shaft.shaft)
        self._store(table.GOAL_POSITION, self._reported(self._shaft.shaft))
        self._store(table.GOAL_VELOCITY, 0)
        self._ongoing = False

    def _measure(self, outside: float = 0.0) -> None:
        load = -outside / self.model.motor.stall_torque if self.energised else 0.0
        velocity = round(self._direction * self._shaft.velocity * self.model.tick / self.model.velocity_unit)
        moving = abs(velocity) > self.value(table.MOVING_THRESHOLD) or self._ongoing
        arrived = abs(self._shaft.shaft - self._shaft_at(self.value(table.GOAL_POSITION))) < 10.0
        store = self._store
        store(table.REALTIME_TICK, int(self._milliseconds) % TICK_WRAP)
        store(table.MOVING, int(moving))
        store(table.MOVING_STATUS, self._profile_bits() | (2 if self._ongoing else 0) | (1 if arrived else 0))
        store(table.PRESENT_PWM, round(min(max(load, -1.0), 1.0) * self.model.full_pwm))
        measured, most = self.model.load, 32767 if self.model.current_unit else 1000
        store(measured, self._direction * round(min(max(load / self.model.load_unit, -most), most)))
        store(table.PRESENT_VELOCITY, velocity)
        store(table.PRESENT_POSITION, self._reported(self._shaft.shaft))
        store(table.VELOCITY_TRAJECTORY, velocity if self._ongoing else 0)
        store(table.POSITION_TRAJECTORY, self._reported(self._shaft.position))
        store(table.PRESENT_INPUT_VOLTAGE, round(self.voltage / table.VOLTAGE_UNIT))
        store(table.PRESENT_TEMPERATURE, round(self.temperature))

    def _profile_bits(self) -> int:
        """Return bits 4 and 5 of Moving Status: trapezoidal, rectangular or no profile."""
        if not self.value(table.PROFILE_VELOCITY):
            return 0
        return 0b11 << 4 if self.value(table.PROFILE_ACCELERATION) else 0b01 << 4
