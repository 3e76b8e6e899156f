"""One emulated servo: control table with its rules, watchdog, velocity profile, load and hardware errors."""

from collections.abc import Callable

from tendond.drivers.dynamixel import table
from tendond.drivers.dynamixel.emulator.motion import Actuator
from tendond.drivers.dynamixel.emulator.protocol import Error
from tendond.drivers.dynamixel.table import Register
from tendond.schemas.config_servo import STALL_TORQUE, WATCHDOG_UNIT

LAG = 0.02
"""[s] between the profile and the shaft, for the position loop and the gears."""

BACKDRIVE = 10.0
"""[rad/s per N m]: how fast a servo without torque gives way."""

OVERLOAD_SECONDS = 1.0
SLIP = 0.5
"""[rad/s] at which a servo gives way that is pulled at by more than it can hold."""

_AT = {register.address: register for register in table.REGISTERS}


class EmulatedServo:
    """State of a servo.

    Args:
        identifier: on the bus.
        baudrate: it listens at.
        position: of the shaft at power-up [ticks]; only the place within a turn survives.

    Attributes:
        torque: on the shaft from outside, by its position [ticks]: [N m], positive towards larger positions.
        silent: it answers nothing, and does nothing.
        temperature: [degree Celsius], voltage: [V].
        stuck: the shaft cannot move.
    """

    def __init__(self, identifier: int, baudrate: int = 57600, position: int = 2048) -> None:
        self._data = bytearray(table.TABLE_SIZE)
        for register in table.REGISTERS:
            if register.eeprom:
                self._store(register, register.initial)
        self._store(table.ID, identifier)
        self._store(table.BAUD_RATE, table.BAUD_CODES[baudrate])
        self.torque: Callable[[float], float] = lambda position: 0.0
        self.silent = False
        self.stuck = False
        self.temperature = 30.0
        self.voltage = 12.0
        self._shaft = Actuator()
        self._shaft.place(float(position))
        self.power_up()

    def value(self, register: Register) -> int:
        """What a register holds."""
        return register.from_bytes(bytes(self._data[register.address : register.address + register.size]))

    def _store(self, register: Register, value: int) -> None:
        self._data[register.address : register.address + register.size] = register.to_bytes(value)

    @property
    def id(self) -> int:
        """On the bus."""
        return self.value(table.ID)

    @property
    def baudrate(self) -> int:
        """[bit/s]"""
        return next(rate for rate, code in table.BAUD_CODES.items() if code == self.value(table.BAUD_RATE))

    @property
    def position(self) -> float:
        """Of the shaft [ticks]."""
        return self._shaft.shaft

    @property
    def energised(self) -> bool:
        """Torque is on."""
        return bool(self.value(table.TORQUE_ENABLE))

    def power_up(self) -> None:
        """Or reboot: RAM as in the factory, errors gone, turns forgotten."""
        for register in table.REGISTERS:
            if not register.eeprom:
                self._store(register, register.initial)
        self._shaft.place(self._shaft.shaft % table.TICKS_PER_TURN)
        self._since_packet = 0.0
        self._overloaded = 0.0
        self._error = 0
        self._measure()

    def fail(self, bit: int) -> None:
        """Set a hardware error; the torque goes off where `SHUTDOWN` says so."""
        self._error |= 1 << bit
        self._store(table.HARDWARE_ERROR_STATUS, self._error)
        if self.value(table.SHUTDOWN) & 1 << bit:
            self._store(table.TORQUE_ENABLE, 0)

    @property
    def alert(self) -> bool:
        """There is a hardware error."""
        return self._error != 0

    def heard(self) -> None:
        """An instruction packet has come in."""
        self._since_packet = 0.0

    def read(self, address: int, length: int) -> bytes | None:
        """Bytes of the table; none where there are none."""
        if length == 0 or address + length > table.TABLE_SIZE:
            return None
        return bytes(self._data[address : address + length])

    def write(self, address: int, data: bytes) -> Error:
        """Write whole registers; the first that is refused ends it."""
        while data:
            register = _AT.get(address)
            if register is None or register.read_only:
                return Error.ACCESS
            if len(data) < register.size:
                return Error.DATA_LENGTH
            error = self._write(register, register.from_bytes(data[: register.size]))
            if error is not Error.NONE:
                return error
            address, data = address + register.size, data[register.size :]
        return Error.NONE

    def _write(self, register: Register, value: int) -> Error:
        if register.eeprom and self.energised:
            return Error.ACCESS
        if not register.least <= value <= register.most:
            return Error.DATA_RANGE
        if register is table.GOAL_POSITION and self.value(table.BUS_WATCHDOG) == table.WATCHDOG_TRIPPED:
            return Error.DATA_RANGE
        if register is table.TORQUE_ENABLE:
            if value and self._error & self.value(table.SHUTDOWN):
                return Error.RESULT_FAIL
            if value and not self.energised:
                self._shaft.place(self._shaft.shaft)
                self._store(table.GOAL_POSITION, round(self._shaft.shaft))
        if register is table.OPERATING_MODE and value != self.value(register):
            self._shaft.place(self._shaft.shaft % table.TICKS_PER_TURN)
        self._store(register, value)
        return Error.NONE

    def advance(self, duration: float) -> None:
        """Let `duration` [s] pass."""
        outside = self.torque(self._shaft.shaft)
        self._watch(duration)
        if self.temperature > self.value(table.TEMPERATURE_LIMIT):
            self.fail(2)
        if not 0.1 * self.value(table.MIN_VOLTAGE_LIMIT) <= self.voltage <= 0.1 * self.value(table.MAX_VOLTAGE_LIMIT):
            self.fail(0)
        beyond = abs(outside) > STALL_TORQUE
        self._overloaded = self._overloaded + duration if beyond and self.energised else 0.0
        if self._overloaded > OVERLOAD_SECONDS:
            self.fail(5)
        if self.stuck:
            self._shaft.place(self._shaft.shaft)
        elif not self.energised:
            self._shaft.place(self._shaft.shaft + BACKDRIVE * outside * duration / table.TICK)
        elif beyond:
            self._shaft.place(self._shaft.shaft + (SLIP if outside > 0.0 else -SLIP) * duration / table.TICK)
        else:
            profile = min(self.value(table.PROFILE_VELOCITY) or 32767, self.value(table.VELOCITY_LIMIT))
            self._shaft.rate = profile * table.VELOCITY_UNIT / table.TICK
            self._shaft.acceleration = self.value(table.PROFILE_ACCELERATION) * table.ACCELERATION_UNIT / table.TICK
            self._shaft.lag = LAG
            self._shaft.step(float(self.value(table.GOAL_POSITION)), duration)
        self._measure(outside)

    def _watch(self, duration: float) -> None:
        """The Bus Watchdog: without packets for so long, stop here and refuse goals."""
        self._since_packet += duration
        limit = self.value(table.BUS_WATCHDOG)
        if self.energised and limit > 0 and self._since_packet > limit * WATCHDOG_UNIT:
            self._store(table.BUS_WATCHDOG, table.WATCHDOG_TRIPPED)
            self._store(table.GOAL_POSITION, round(self._shaft.shaft))
            self._shaft.place(self._shaft.shaft)

    def _measure(self, outside: float = 0.0) -> None:
        load = -outside / STALL_TORQUE / table.LOAD_UNIT if self.energised else 0.0
        self._store(table.PRESENT_LOAD, round(min(max(load, -1000.0), 1000.0)))
        self._store(table.PRESENT_VELOCITY, round(self._shaft.velocity * table.TICK / table.VELOCITY_UNIT))
        self._store(table.PRESENT_POSITION, round(self._shaft.shaft))
        self._store(table.PRESENT_INPUT_VOLTAGE, round(self.voltage / table.VOLTAGE_UNIT))
        self._store(table.PRESENT_TEMPERATURE, round(self.temperature))
