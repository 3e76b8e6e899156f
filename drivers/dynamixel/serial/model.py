"""A model of servo: its control table, units, modes and the requests that read its state."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.port import RefusedError
from tendond.drivers.dynamixel.serial.register import Register
from tendond.schemas.motors import Motor


@dataclass(frozen=True)
class ReadRequest:
    """Read of `length` bytes from `address` on, with all of a servo's state; `model` decodes the reply."""

    address: int
    length: int
    model: "ServoModel"


@dataclass(frozen=True)
class ServoModel:
    """A model of servo.

    Attributes:
        motor: its ratings.
        registers: its control table, with the manual's names.
        modes: values of Operating Mode.
        velocity_unit: unit of Profile, Goal and Present Velocity [rad/s].
        acceleration_unit: unit of Profile Acceleration [rad/s^2].
        full_pwm: value of PWM Limit for the whole supply voltage.
        current_unit: unit of currents [A]; 0 where the model does not measure its current.
        baud_codes: value of Baud Rate by rate [bit/s].
        reads: first and last register of each request for a servo's state; all of different length, so that a reply
            shows to which it belongs.
        clears_profile: a tripped Bus Watchdog clears the profile.
        centred: a position after power-up is within half a turn of 0, not from 0 to a turn.
    """

    motor: Motor
    registers: tuple[Register, ...]
    velocity_unit: float
    acceleration_unit: float
    full_pwm: int
    current_unit: float
    baud_codes: dict[int, int]
    reads: tuple[tuple[str, str], ...]
    clears_profile: bool
    centred: bool

    @property
    def name(self) -> str:
        """Name, as in `servo.model`."""
        return self.motor.name

    @property
    def number(self) -> int:
        """Value of Model Number."""
        return self.motor.number

    @property
    def tick(self) -> float:
        """Unit of positions [rad]."""
        return self.motor.tick

    @cached_property
    def _by_name(self) -> dict[str, Register]:
        return {register.name: register for register in self.registers}

    def has(self, register: Register) -> bool:
        """Return true where the model has a register of that name."""
        return register.name in self._by_name

    def entry(self, register: Register) -> Register:
        """Return the model's entry for a register, by its name.

        Raises:
            RefusedError: it has none.
        """
        try:
            return self._by_name[register.name]
        except KeyError:
            raise RefusedError(f"{self.name} has no {register.name}") from None

    @property
    def load(self) -> Register:
        """Present Load, or Present Current where the model measures that."""
        return self.entry(table.PRESENT_CURRENT if self.current_unit else table.PRESENT_LOAD)

    @property
    def load_unit(self) -> float:
        """Unit of `load`, as a fraction of the stall torque [-]; torque is proportional to current."""
        return self.current_unit / self.motor.stall_current if self.current_unit else table.LOAD_UNIT

    @cached_property
    def table_size(self) -> int:
        """Bytes of the control table."""
        return max(register.address + register.size for register in self.registers)

    @cached_property
    def requests(self) -> Sequence[ReadRequest]:
        """Requests for a servo's state."""
        found = []
        for first, last in self.reads:
            start, end = self._by_name[first], self._by_name[last]
            found.append(ReadRequest(start.address, end.address + end.size - start.address, self))
        return found

    def current_goal(self, amperes: float) -> int:
        """Return the Goal Current for a limit [A], rounded down, and within Current Limit."""
        return max(0, min(int(amperes / self.current_unit), self.entry(table.CURRENT_LIMIT).initial))

    def __hash__(self) -> int:
        return hash(self.motor.number)
