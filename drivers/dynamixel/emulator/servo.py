"""One emulated servo, by the manual: control table and its rules, motor, gears, watchdog, hardware errors, power."""

import math
from collections.abc import Callable

from tendond.drivers.dynamixel.emulator.control_table import ControlTable
from tendond.drivers.dynamixel.emulator.motion import Actuator
from tendond.drivers.dynamixel.emulator.protocol import Error
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.table import Register
from tendond.schemas.config.servo import NO_LOAD_SPEED, STALL_TORQUE, WATCHDOG_UNIT

SHAFT_LAG = 0.02
"""[s] between the profile and the shaft, for the position loop and the gears."""

BACKDRIVE = 10.0
"""[rad/s per N m]: how fast a servo without torque gives way."""

OVERLOAD_SECONDS = 1.0
SLIP_RATE = 0.5
"""[rad/s] at which a servo gives way that is pulled at by more than it can hold."""

RATED_VOLTS = 11.1
"""At which the manual gives `STALL_TORQUE` and `NO_LOAD_SPEED`; both grow with the voltage."""

BROWN_OUT_VOLTS = 5.0
"""Below it the servo's processor stops; the manual has only the motor's 6.5 V, so this is a guess."""

TICK_WRAP = 32768
"""Realtime Tick counts milliseconds from 0 to 32767."""

MOVES_IN_MODE = {1: table.GOAL_VELOCITY, 16: table.GOAL_PWM}
GOALS = (table.GOAL_PWM, table.GOAL_VELOCITY, table.GOAL_POSITION)
CLEAR_TURNS = b"\x01\x44\x58\x4c\x22"
RESET_ALL, RESET_BUT_ID, RESET_BUT_ID_AND_RATE = 0xFF, 0x01, 0x02


class EmulatedServo:
    """State of a servo.

    Args:
        identifier: on the bus.
        baudrate: it listens at.
        position: of the shaft at power-up [ticks]; the servo knows only the place within a turn.

    Attributes:
        torque: on the shaft from outside, by its position [ticks]: [N m], positive towards larger positions.
        silent: it answers nothing, and does nothing.
        temperature: [degree Celsius], voltage: [V].
        stuck: the shaft cannot move.
        grip: torque against which the gears hold a shaft without torque [N m].
    """

    def __init__(self, identifier: int, baudrate: int = 57600, position: int = 2048) -> None:
        self._memory = ControlTable()
        self._store(table.ID, identifier)
        self._store(table.BAUD_RATE, table.BAUD_CODES[baudrate])
        self.torque: Callable[[float], float] = lambda position: 0.0
        self.silent = False
        self.stuck = False
        self.temperature = 30.0
        self.voltage = 12.0
        self.grip = 0.0
        self._shaft = Actuator()
        self._shaft.place(float(position))
        self._milliseconds = 0.0
        self._begun_at = float(position)
        self.power_up()

    def value(self, register: Register) -> int:
        """What a register holds."""
        return self._memory.value(register)

    def _store(self, register: Register, value: int) -> None:
        self._memory.store(register, value)

    @property
    def id(self) -> int:
        """On the bus."""
        return self.value(table.ID)

    @property
    def secondary(self) -> int | None:
        """The Secondary ID, if it has one."""
        value = self.value(table.SECONDARY_ID)
        return value if value <= table.ID.maximum and value != self.id else None

    @property
    def baudrate(self) -> int:
        """[bit/s]"""
        return next(rate for rate, code in table.BAUD_CODES.items() if code == self.value(table.BAUD_RATE))

    @property
    def position(self) -> float:
        """Of the shaft [ticks], with all its turns, whatever the servo knows of them."""
        return self._shaft.shaft

    @property
    def energised(self) -> bool:
        """Torque is on."""
        return bool(self.value(table.TORQUE_ENABLE))

    @property
    def dark(self) -> bool:
        """It has no power, or too little."""
        return self._dark

    @property
    def deaf(self) -> bool:
        """It hears nothing and answers nothing."""
        return self.silent or self._dark

    @property
    def alert(self) -> bool:
        """There is a hardware error."""
        return self._error != 0

    @property
    def return_delay(self) -> float:
        """[s] before it answers."""
        return self.value(table.RETURN_DELAY_TIME) * table.RETURN_DELAY_UNIT

    def power_up(self) -> None:
        """Or reboot: RAM as in the factory, errors gone, turns forgotten."""
        self._memory.reset(eeprom=False)
        self._store(table.GOAL_PWM, self.value(table.PWM_LIMIT))
        self._dark = False
        self._since_packet = 0.0
        self._overloaded = 0.0
        self._error = 0
        self._registered: tuple[int, bytes] | None = None
        self._ongoing = False
        self._forget_turns()
        if self.value(table.STARTUP_CONFIGURATION) & 1:
            self._switch_on()
        self._measure()

    def factory_reset(self, option: int) -> Error:
        """EEPROM as in the factory, but for what the option keeps; then it starts anew."""
        if option not in (RESET_ALL, RESET_BUT_ID, RESET_BUT_ID_AND_RATE) or self.energised:
            return Error.RESULT_FAIL if self.energised else Error.DATA_RANGE
        identifier, rate = self.id, self.value(table.BAUD_RATE)
        self._memory.reset(eeprom=True)
        if option != RESET_ALL:
            self._store(table.ID, identifier)
        if option == RESET_BUT_ID_AND_RATE:
            self._store(table.BAUD_RATE, rate)
        self.power_up()
        return Error.NONE

    def clear(self, parameters: bytes) -> Error:
        """Forget the turns, where it stands still."""
        if parameters != CLEAR_TURNS:
            return Error.DATA_RANGE
        if self.value(table.MOVING):
            return Error.RESULT_FAIL
        self._forget_turns()
        self._measure()
        if self.energised:
            self._hold()
        return Error.NONE

    def count_turns(self, turns: int) -> None:
        """Count so many whole turns more, as if the shaft had been turned by them."""
        self._turns += turns
        self._measure()
        if self.energised:
            self._hold()

    def _forget_turns(self) -> None:
        """Take the shaft's place for one within a single turn."""
        self._turns = -math.floor(self._shaft.shaft / table.TICKS_PER_TURN)

    @property
    def _direction(self) -> int:
        return -1 if self.value(table.DRIVE_MODE) & table.REVERSE else 1

    def _reported(self, shaft: float) -> int:
        """Present Position of a place of the shaft."""
        counted = shaft + self._turns * table.TICKS_PER_TURN
        return round(self._direction * counted) + self.value(table.HOMING_OFFSET)

    def _meant(self, goal: int) -> float:
        """Place of the shaft for a Goal Position."""
        counted = self._direction * (goal - self.value(table.HOMING_OFFSET))
        return float(counted - self._turns * table.TICKS_PER_TURN)

    def _hold(self) -> None:
        """Goal and shaft here."""
        self._shaft.place(self._shaft.shaft)
        self._store(table.GOAL_POSITION, self._reported(self._shaft.shaft))
        self._store(table.GOAL_VELOCITY, 0)
        self._ongoing = False

    def _switch_on(self) -> None:
        if self.value(table.OPERATING_MODE) == table.POSITION:
            self._forget_turns()
        self._hold()
        self._store(table.TORQUE_ENABLE, 1)

    def fail(self, bit: int) -> None:
        """Set a hardware error; the torque goes off where `SHUTDOWN` says so."""
        self._error |= 1 << bit
        self._store(table.HARDWARE_ERROR_STATUS, self._error)
        if self.value(table.SHUTDOWN) & 1 << bit:
            self._store(table.TORQUE_ENABLE, 0)

    def packet_received(self) -> None:
        """An instruction packet has come in."""
        self._since_packet = 0.0

    def answers(self, *, reads: bool) -> bool:
        """Whether Status Return Level lets it answer a read, or any other instruction but a ping."""
        return self.value(table.STATUS_RETURN_LEVEL) >= (1 if reads else 2)

    def read(self, address: int, length: int) -> bytes | None:
        """Bytes of the table; none where there are none."""
        return self._memory.read(address, length)

    def register(self, address: int, data: bytes) -> Error:
        """Keep a write until `act`."""
        for register, part in self._memory.items(address, data):
            if register is None or register.read_only:
                return Error.ACCESS
            if len(part) < register.size:
                return Error.DATA_LENGTH
        self._registered = address, data
        self._store(table.REGISTERED_INSTRUCTION, 1)
        return Error.NONE

    def act(self) -> Error:
        """Carry out the write that was kept."""
        if self._registered is None:
            return Error.INSTRUCTION
        (address, data), self._registered = self._registered, None
        self._store(table.REGISTERED_INSTRUCTION, 0)
        return self.write(address, data)

    def write(self, address: int, data: bytes, *, primary: bool = True) -> Error:
        """Write whole registers; the first that is refused ends it.

        Args:
            address, data: of the write.
            primary: it was addressed to the ID, not to the Secondary ID, which cannot change the EEPROM.
        """
        for register, part in self._memory.items(address, data):
            if register is None or register.read_only or (register.eeprom and not primary):
                return Error.ACCESS
            if len(part) < register.size:
                return Error.DATA_LENGTH
            error = self._write(register, register.from_bytes(part))
            if error is not Error.NONE:
                return error
        return Error.NONE

    def _write(self, register: Register, value: int) -> Error:
        error = self._refusal(register, value)
        if error is not Error.NONE:
            return error
        mode = self.value(table.OPERATING_MODE)
        if register is table.TORQUE_ENABLE and value and not self.energised:
            self._switch_on()
        elif register is table.OPERATING_MODE and value != mode:
            self._store(register, value)
            self._new_mode(value)
            return error
        elif register in GOALS and not self.energised and self.value(table.DRIVE_MODE) & table.TORQUE_ON_BY_GOAL:
            if self._error & self.value(table.SHUTDOWN):
                return Error.RESULT_FAIL
            self._switch_on()
        if register is table.GOAL_POSITION and self.energised:
            self._begun_at = self._shaft.position
            self._ongoing = True
        self._store(register, value)
        return error

    def _refusal(self, register: Register, value: int) -> Error:
        """Why a value cannot be written now."""
        if register.eeprom and self.energised:
            return Error.ACCESS
        if not register.accepts(value):
            return Error.DATA_RANGE
        if register in GOALS and self.value(table.BUS_WATCHDOG) == table.WATCHDOG_TRIPPED:
            return Error.DATA_RANGE
        if register is table.GOAL_PWM and abs(value) > self.value(table.PWM_LIMIT):
            return Error.DATA_LIMIT
        if register is table.GOAL_VELOCITY and abs(value) > self.value(table.VELOCITY_LIMIT):
            return Error.DATA_LIMIT
        one_turn = register is table.GOAL_POSITION and self.value(table.OPERATING_MODE) == table.POSITION
        if one_turn and not self.value(table.MIN_POSITION_LIMIT) <= value <= self.value(table.MAX_POSITION_LIMIT):
            return Error.DATA_LIMIT
        if register is table.TORQUE_ENABLE and value and self._error & self.value(table.SHUTDOWN):
            return Error.RESULT_FAIL
        return Error.NONE

    def _new_mode(self, mode: int) -> None:
        """What a change of Operating Mode resets."""
        if mode in (table.POSITION, table.EXTENDED_POSITION):
            self._forget_turns()
        self._store(table.PROFILE_VELOCITY, 0)
        self._store(table.PROFILE_ACCELERATION, 0)
        self._store(table.GOAL_PWM, self.value(table.PWM_LIMIT))
        for gain in (table.VELOCITY_I_GAIN, table.VELOCITY_P_GAIN, table.POSITION_D_GAIN, table.POSITION_P_GAIN):
            self._store(gain, gain.initial)

    def advance(self, duration: float) -> None:
        """Let `duration` [s] pass."""
        if self._power(duration):
            return
        outside = self.torque(self._shaft.shaft)
        self._milliseconds += 1e3 * duration
        self._watch(duration)
        self._protect(outside, duration)
        if self.stuck:
            self._shaft.place(self._shaft.shaft)
        elif not self.energised:
            self._give_way(outside, duration)
        elif abs(outside) > self._holds:
            self._shaft.place(self._shaft.shaft + math.copysign(SLIP_RATE, outside) * duration / table.TICK)
        else:
            self._drive(outside, duration)
        self._measure(outside)

    def _power(self, duration: float) -> bool:
        """Brown-out: without enough voltage it stops, and starts anew with it; true while it is dark."""
        if self.voltage < BROWN_OUT_VOLTS:
            self._dark = True
            self._store(table.TORQUE_ENABLE, 0)
            self._give_way(self.torque(self._shaft.shaft), duration)
        elif self._dark:
            self.power_up()
        return self._dark

    def _give_way(self, outside: float, duration: float) -> None:
        """Without torque: the gears hold so much, and are turned by the rest."""
        rest = max(0.0, abs(outside) - self.grip)
        self._shaft.place(self._shaft.shaft + math.copysign(BACKDRIVE * rest, outside) * duration / table.TICK)

    @property
    def _duty(self) -> float:
        """Largest output of the motor, of all that it has at its rated voltage."""
        limit = min(abs(self.value(table.GOAL_PWM)), self.value(table.PWM_LIMIT))
        return limit / table.FULL_PWM * self.voltage / RATED_VOLTS

    @property
    def _holds(self) -> float:
        """Torque that it can hold [N m]."""
        return STALL_TORQUE * self._duty

    def _protect(self, outside: float, duration: float) -> None:
        if self.temperature > self.value(table.TEMPERATURE_LIMIT):
            self.fail(table.HOT_ERROR)
        if not 0.1 * self.value(table.MIN_VOLTAGE_LIMIT) <= self.voltage <= 0.1 * self.value(table.MAX_VOLTAGE_LIMIT):
            self.fail(table.VOLTAGE_ERROR)
        beyond = self.energised and abs(outside) > STALL_TORQUE
        self._overloaded = self._overloaded + duration if beyond else 0.0
        if self._overloaded > OVERLOAD_SECONDS:
            self.fail(table.OVERLOAD_ERROR)

    def _drive(self, outside: float, duration: float) -> None:
        """Turn as the mode says; a motor is slower by its load: speed and torque share the voltage."""
        mode = self.value(table.OPERATING_MODE)
        shaft = self._shaft
        shaft.acceleration = self.value(table.PROFILE_ACCELERATION) * table.ACCELERATION_UNIT / table.TICK
        shaft.lag = SHAFT_LAG
        if mode in MOVES_IN_MODE:
            goal = self.value(MOVES_IN_MODE[mode]) * self._direction
            wanted = goal * table.VELOCITY_UNIT if mode == 1 else NO_LOAD_SPEED * goal / table.FULL_PWM
            shaft.rate = max(abs(wanted), 1e-9) / table.TICK
            shaft.step(shaft.position + math.copysign(1e9, wanted) if wanted else shaft.shaft, duration)
            return
        goal_shaft = self._meant(self.value(table.GOAL_POSITION))
        ahead = goal_shaft - shaft.shaft
        against = -math.copysign(1.0, ahead) * outside / STALL_TORQUE
        able = NO_LOAD_SPEED * max(0.0, self._duty - against)
        shaft.rate = max(min(self._profile_speed(goal_shaft), able), 1e-6) / table.TICK
        shaft.step(goal_shaft, duration)
        self._ongoing = self._ongoing and abs(shaft.position - goal_shaft) > 0.5

    def _profile_speed(self, goal: float) -> float:
        """[rad/s]; a time-based profile's from the time that it may take."""
        profile = self.value(table.PROFILE_VELOCITY)
        if profile == 0:
            return NO_LOAD_SPEED * self.voltage / RATED_VOLTS
        if self.value(table.DRIVE_MODE) & table.TIME_BASED:
            return abs(goal - self._begun_at) * table.TICK / (1e-3 * profile)
        return profile * table.VELOCITY_UNIT

    def _watch(self, duration: float) -> None:
        """The Bus Watchdog: without packets for so long, stop here, clear the profiles and refuse goals."""
        self._since_packet += duration
        limit = self.value(table.BUS_WATCHDOG)
        if self.energised and limit > 0 and self._since_packet > limit * WATCHDOG_UNIT:
            self._hold()
            self._store(table.BUS_WATCHDOG, table.WATCHDOG_TRIPPED)
            self._store(table.PROFILE_VELOCITY, 0)
            self._store(table.PROFILE_ACCELERATION, 0)

    def _measure(self, outside: float = 0.0) -> None:
        load = -outside / STALL_TORQUE if self.energised else 0.0
        velocity = round(self._direction * self._shaft.velocity * table.TICK / table.VELOCITY_UNIT)
        moving = abs(velocity) > self.value(table.MOVING_THRESHOLD) or self._ongoing
        arrived = abs(self._shaft.shaft - self._meant(self.value(table.GOAL_POSITION))) < 10.0
        store = self._store
        store(table.REALTIME_TICK, int(self._milliseconds) % TICK_WRAP)
        store(table.MOVING, int(moving))
        store(table.MOVING_STATUS, self._profile_bits() | (2 if self._ongoing else 0) | (1 if arrived else 0))
        store(table.PRESENT_PWM, round(min(max(load, -1.0), 1.0) * table.FULL_PWM))
        store(table.PRESENT_LOAD, self._direction * round(min(max(load / table.LOAD_UNIT, -1000.0), 1000.0)))
        store(table.PRESENT_VELOCITY, velocity)
        store(table.PRESENT_POSITION, self._reported(self._shaft.shaft))
        store(table.VELOCITY_TRAJECTORY, velocity if self._ongoing else 0)
        store(table.POSITION_TRAJECTORY, self._reported(self._shaft.position))
        store(table.PRESENT_INPUT_VOLTAGE, round(self.voltage / table.VOLTAGE_UNIT))
        store(table.PRESENT_TEMPERATURE, round(self.temperature))

    def _profile_bits(self) -> int:
        """Bits 4 and 5 of Moving Status: trapezoidal, rectangular, or no profile at all."""
        if not self.value(table.PROFILE_VELOCITY):
            return 0
        return 0b11 << 4 if self.value(table.PROFILE_ACCELERATION) else 0b01 << 4
