"""Emulated servo by the manual: instructions and rules of its control table."""

from tendond.drivers.dynamixel.emulator.motor import EmulatedMotor
from tendond.drivers.dynamixel.emulator.protocol import Error
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.model import ServoModel
from tendond.drivers.dynamixel.serial.models import XL430
from tendond.drivers.dynamixel.serial.register import Register

GOALS = (table.GOAL_PWM, table.GOAL_CURRENT, table.GOAL_VELOCITY, table.GOAL_POSITION)
POSITIONS = (table.POSITION, table.EXTENDED_POSITION, table.CURRENT_POSITION)
LIMITS = {
    table.GOAL_PWM: table.PWM_LIMIT,
    table.GOAL_CURRENT: table.CURRENT_LIMIT,
    table.GOAL_VELOCITY: table.VELOCITY_LIMIT,
}
CLEAR_TURNS = b"\x01\x44\x58\x4c\x22"
RESET_ALL, RESET_BUT_ID, RESET_BUT_ID_AND_RATE = 0xFF, 0x01, 0x02


class EmulatedServo(EmulatedMotor):
    """Servo on a bus.

    Args:
        identifier: number on the bus.
        baudrate: baudrate of the servo [bit/s].
        position: position of the shaft at power-up [ticks]; the servo knows only the position within a turn.
        model: of the servo.

    Attributes:
        silent: it neither replies nor acts.
    """

    def __init__(self, identifier: int, baudrate: int = 57600, position: int = 2048, model: ServoModel = XL430) -> None:
        super().__init__(position, model)
        self._store(table.ID, identifier)
        self._store(table.BAUD_RATE, self.model.baud_codes[baudrate])
        self.silent = False

    def power_up(self) -> None:
        """Power up or reboot: RAM has its initial values; errors, turns and a registered write are lost."""
        self._registered: tuple[int, bytes] | None = None
        super().power_up()

    @property
    def id(self) -> int:
        """Id on the bus."""
        return self.value(table.ID)

    @property
    def secondary(self) -> int | None:
        """Secondary ID, if it has one."""
        value = self.value(table.SECONDARY_ID)
        return value if value <= table.ID.maximum and value != self.id else None

    @property
    def baudrate(self) -> int:
        """Baud rate [bit/s]."""
        return next(rate for rate, code in self.model.baud_codes.items() if code == self.value(table.BAUD_RATE))

    @property
    def deaf(self) -> bool:
        """True while it neither receives nor replies."""
        return self.silent or self._dark

    @property
    def return_delay(self) -> float:
        """Delay of its replies [s]."""
        return self.value(table.RETURN_DELAY_TIME) * table.RETURN_DELAY_UNIT

    def factory_reset(self, option: int) -> Error:
        """Reset the EEPROM, except what the option keeps, and reboot."""
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
        """Clear the turns of a shaft that stands still."""
        if parameters != CLEAR_TURNS:
            return Error.DATA_RANGE
        if self.value(table.MOVING):
            return Error.RESULT_FAIL
        self._forget_turns()
        self._measure()
        if self.energised:
            self._hold()
        return Error.NONE

    def packet_received(self) -> None:
        """Note an instruction packet, for the Bus Watchdog."""
        self._since_packet = 0.0

    def replies(self, *, reads: bool) -> bool:
        """Return true where Status Return Level allows a reply to a read, or to other instructions but a ping."""
        return self.value(table.STATUS_RETURN_LEVEL) >= (1 if reads else 2)

    def read(self, address: int, length: int) -> bytes | None:
        """Read bytes of the control table; none where no register begins."""
        return self._memory.read(address, length)

    def register(self, address: int, data: bytes) -> Error:
        """Register a write (Reg Write) until `act`."""
        for register, part in self._memory.items(address, data):
            if register is None or register.read_only:
                return Error.ACCESS
            if len(part) < register.size:
                return Error.DATA_LENGTH
        self._registered = address, data
        self._store(table.REGISTERED_INSTRUCTION, 1)
        return Error.NONE

    def act(self) -> Error:
        """Carry out the registered write (Action)."""
        if self._registered is None:
            return Error.INSTRUCTION
        (address, data), self._registered = self._registered, None
        self._store(table.REGISTERED_INSTRUCTION, 0)
        return self.write(address, data)

    def put(self, register: Register, value: int) -> Error:
        """Write a register by its name, as a host does."""
        entry = self.model.entry(register)
        return self.write(entry.address, entry.to_bytes(value))

    def write(self, address: int, data: bytes, *, primary: bool = True) -> Error:
        """Write whole registers, up to the first that is refused.

        Args:
            address, data: of the write.
            primary: addressed to the ID, not to the Secondary ID, which cannot change the EEPROM.
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
        if register == table.TORQUE_ENABLE and value and not self.energised:
            self._switch_on()
        elif register == table.OPERATING_MODE and value != mode:
            self._store(register, value)
            self._new_mode(value)
            return error
        elif register in GOALS and not self.energised and self.value(table.DRIVE_MODE) & table.TORQUE_ON_BY_GOAL:
            if self._error & self.value(table.SHUTDOWN):
                return Error.RESULT_FAIL
            self._switch_on()
        if register == table.GOAL_POSITION and self.energised:
            self._profile_start = self._shaft.position
            self._ongoing = True
        self._store(register, value)
        return error

    def _refusal(self, register: Register, value: int) -> Error:
        """Return the error of a value that cannot be written now."""
        if register.eeprom and self.energised:
            return Error.ACCESS
        if not register.accepts(value):
            return Error.DATA_RANGE
        if register in GOALS and self.value(table.BUS_WATCHDOG) == table.WATCHDOG_TRIPPED:
            return Error.DATA_RANGE
        if (limit := LIMITS.get(register)) is not None and abs(value) > self.value(limit):
            return Error.DATA_LIMIT
        if self.model.has(table.ACCELERATION_LIMIT) and self._beyond_profile(register, value):
            return Error.DATA_LIMIT
        one_turn = register == table.GOAL_POSITION and self.value(table.OPERATING_MODE) == table.POSITION
        if one_turn and not self.value(table.MIN_POSITION_LIMIT) <= value <= self.value(table.MAX_POSITION_LIMIT):
            return Error.DATA_LIMIT
        if register == table.TORQUE_ENABLE and value and self._error & self.value(table.SHUTDOWN):
            return Error.RESULT_FAIL
        return Error.NONE

    def _beyond_profile(self, register: Register, value: int) -> bool:
        """Return true for a profile above the limits of its EEPROM, which a model with Acceleration Limit refuses."""
        limits = {table.PROFILE_VELOCITY: table.VELOCITY_LIMIT, table.PROFILE_ACCELERATION: table.ACCELERATION_LIMIT}
        return register in limits and value > self.value(limits[register])

    def _new_mode(self, mode: int) -> None:
        """Reset what a change of Operating Mode resets."""
        if mode in POSITIONS:
            self._forget_turns()
        self._store(table.PROFILE_VELOCITY, 0)
        self._store(table.PROFILE_ACCELERATION, 0)
        self._reset_goals()
        for gain in (table.VELOCITY_I_GAIN, table.VELOCITY_P_GAIN, table.POSITION_D_GAIN, table.POSITION_P_GAIN):
            self._store(gain, self.model.entry(gain).initial)
