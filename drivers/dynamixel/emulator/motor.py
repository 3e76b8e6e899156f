"""Motor and gears of an emulated servo: profile, load, watchdog, protection, supply voltage."""

import math
from collections.abc import Callable

from tendond.drivers.dynamixel.emulator.shaft import EmulatedShaft
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.model import ServoModel
from tendond.schemas.config.servo import WATCHDOG_UNIT

SHAFT_LAG = 0.02
"""Time constant between profile and shaft, for the position loop and the gears [s]."""

BACKDRIVE = 10.0
"""Speed of a shaft without torque per external torque [rad/s per N m]."""

OVERLOAD_SECONDS = 1.0
NO_TORQUE = 1e-9
"""Stall torque that stands for a motor without output [N m]."""

YIELD_SPEED = 0.5
"""Speed of a shaft under more torque than the motor can hold [rad/s]."""

BROWN_OUT = 5.0 / 6.5
"""Voltage below which the servo's processor stops, as a fraction of its smallest supply [-]; an assumption: the manual
has only the motor's."""

MOVES_IN_MODE = {1: table.GOAL_VELOCITY, 16: table.GOAL_PWM}


class EmulatedMotor(EmulatedShaft):
    """Motor of a shaft.

    Args:
        position: position of the shaft at power-up [ticks]; the servo knows only the position within a turn.
        model: of the servo.

    Attributes:
        torque: external torque on the shaft [N m], as a function of its position [ticks]; positive towards larger
            positions.
        stuck: the shaft cannot move.
        grip: torque against which the gears hold a shaft without torque [N m].
    """

    def __init__(self, position: int, model: ServoModel) -> None:
        super().__init__(position, model)
        self.torque: Callable[[float], float] = lambda position: 0.0
        self.stuck = False
        self.grip = 0.0
        self._profile_start = float(position)
        self.power_up()

    @property
    def dark(self) -> bool:
        """True while the supply voltage is too low for its processor."""
        return self._dark

    @property
    def alert(self) -> bool:
        """True while there is a hardware error."""
        return self._error != 0

    def power_up(self) -> None:
        """Power up or reboot: RAM has its initial values, errors and turns are lost."""
        self._memory.reset(eeprom=False)
        self._reset_goals()
        self._dark = False
        self._since_packet = 0.0
        self._overloaded = 0.0
        self._error = 0
        self._ongoing = False
        self._forget_turns()
        if self.model.has(table.STARTUP_CONFIGURATION) and self.value(table.STARTUP_CONFIGURATION) & 1:
            self._switch_on()
        self._measure()

    def _reset_goals(self) -> None:
        """Set the goals of PWM and current to their limits."""
        self._store(table.GOAL_PWM, self.value(table.PWM_LIMIT))
        if self.model.current_unit:
            self._store(table.GOAL_CURRENT, self.value(table.CURRENT_LIMIT))

    def _switch_on(self) -> None:
        if self.value(table.OPERATING_MODE) == table.POSITION:
            self._forget_turns()
        self._hold()
        self._store(table.TORQUE_ENABLE, 1)

    def fail(self, bit: int) -> None:
        """Set a hardware error; `SHUTDOWN` decides whether the torque goes off."""
        self._error |= 1 << bit
        self._store(table.HARDWARE_ERROR_STATUS, self._error)
        if self.value(table.SHUTDOWN) & 1 << bit:
            self._store(table.TORQUE_ENABLE, 0)

    def advance(self, duration: float) -> None:
        """Advance the servo by `duration` [s]."""
        if self._power(duration):
            return
        outside = self.torque(self._shaft.shaft)
        self._milliseconds += 1e3 * duration
        self._watch(duration)
        self._protect(outside, duration)
        if self.stuck:
            self._shaft.place(self._shaft.shaft)
        elif not self.energised:
            self._backdrive(outside, duration)
        elif abs(outside) > self._torque_max and not self._pulled_to_goal(outside):
            self._shaft.place(self._shaft.shaft + math.copysign(YIELD_SPEED, outside) * duration / self.model.tick)
        else:
            self._drive(outside, duration)
        self._measure(outside)

    def _pulled_to_goal(self, outside: float) -> bool:
        """Return true where an external torque turns the shaft towards its goal."""
        if self.value(table.OPERATING_MODE) in MOVES_IN_MODE:
            return False
        return (self._shaft_at(self.value(table.GOAL_POSITION)) - self._shaft.shaft) * outside > 0.0

    def _power(self, duration: float) -> bool:
        """Stop at a brown-out and reboot after it; true while it lasts."""
        if self.voltage < BROWN_OUT * self.model.motor.voltage[0]:
            self._dark = True
            self._store(table.TORQUE_ENABLE, 0)
            self._backdrive(self.torque(self._shaft.shaft), duration)
        elif self._dark:
            self.power_up()
        return self._dark

    def _backdrive(self, outside: float, duration: float) -> None:
        """Turn a shaft without torque by what exceeds the grip of the gears."""
        rest = max(0.0, abs(outside) - self.grip)
        self._shaft.place(self._shaft.shaft + math.copysign(BACKDRIVE * rest, outside) * duration / self.model.tick)

    @property
    def _duty(self) -> float:
        """Largest output of the motor, as a fraction of that at the rated voltage [-]."""
        limit = min(abs(self.value(table.GOAL_PWM)), self.value(table.PWM_LIMIT))
        return limit / self.model.full_pwm * self.voltage / self.model.motor.rated_volts

    @property
    def _torque_max(self) -> float:
        """Largest torque that it can hold [N m]."""
        motor = self.model.motor
        torque = motor.torque_max * self._duty
        if self.model.current_unit and (motor.continuous or self.value(table.OPERATING_MODE) == table.CURRENT_POSITION):
            torque = min(torque, motor.torque_constant * self.model.current_unit * abs(self.value(table.GOAL_CURRENT)))
        return torque

    def _protect(self, outside: float, duration: float) -> None:
        if self.temperature > self.value(table.TEMPERATURE_LIMIT):
            self.fail(table.HOT_ERROR)
        if not 0.1 * self.value(table.MIN_VOLTAGE_LIMIT) <= self.voltage <= 0.1 * self.value(table.MAX_VOLTAGE_LIMIT):
            self.fail(table.VOLTAGE_ERROR)
        beyond = self.energised and abs(outside) > self.model.motor.torque_max
        self._overloaded = self._overloaded + duration if beyond else 0.0
        if self._overloaded > OVERLOAD_SECONDS:
            self.fail(table.OVERLOAD_ERROR)

    def _drive(self, outside: float, duration: float) -> None:
        """Turn the shaft in the present mode; a load slows the motor, as speed and torque share the voltage."""
        mode = self.value(table.OPERATING_MODE)
        shaft, no_load = self._shaft, self.model.motor.no_load_speed
        shaft.acceleration = self.value(table.PROFILE_ACCELERATION) * self.model.acceleration_unit / self.model.tick
        shaft.lag = SHAFT_LAG
        if mode in MOVES_IN_MODE:
            goal = self.value(MOVES_IN_MODE[mode]) * self._direction
            wanted = goal * self.model.velocity_unit if mode == 1 else no_load * goal / self.model.full_pwm
            shaft.rate, shaft.stall = max(abs(wanted), 1e-9) / self.model.tick, 0.0
            shaft.step(shaft.position + math.copysign(1e9, wanted) if wanted else shaft.shaft, duration)
            return
        goal_shaft = self._shaft_at(self.value(table.GOAL_POSITION))
        shaft.rate = max(self._profile_speed(goal_shaft), 1e-6) / self.model.tick
        shaft.stall, shaft.no_load = max(self._torque_max, NO_TORQUE), no_load * self._duty / self.model.tick
        shaft.step(goal_shaft, duration, -outside)
        self._ongoing = self._ongoing and abs(shaft.position - goal_shaft) > 0.5

    def _profile_speed(self, goal: float) -> float:
        """Return the speed of the profile [rad/s]; that of a time-based profile follows from its time."""
        profile = self.value(table.PROFILE_VELOCITY)
        if profile == 0:
            return self.model.motor.no_load_speed * self.voltage / self.model.motor.rated_volts
        if self.value(table.DRIVE_MODE) & table.TIME_BASED:
            return abs(goal - self._profile_start) * self.model.tick / (1e-3 * profile)
        return profile * self.model.velocity_unit

    def _watch(self, duration: float) -> None:
        """Apply the Bus Watchdog: without packets, stop here, clear the profiles (X series) and refuse goals."""
        self._since_packet += duration
        limit = self.value(table.BUS_WATCHDOG)
        if self.energised and limit > 0 and self._since_packet > limit * WATCHDOG_UNIT:
            self._hold()
            self._store(table.BUS_WATCHDOG, table.WATCHDOG_TRIPPED)
            if self.model.clears_profile:
                self._store(table.PROFILE_VELOCITY, 0)
                self._store(table.PROFILE_ACCELERATION, 0)
