"""What an operator does with servos before the driver runs: find, set up, home, take up slack. One servo moves at a
time, slowly, watched as in operation; whatever ends a motion, the torque is off afterwards.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from tendond.drivers.dynamixel import table
from tendond.drivers.dynamixel.bus import PortLostError, Reading, ServoBus, ServoError
from tendond.drivers.dynamixel.guard import standing_fault
from tendond.drivers.dynamixel.spool import Spool
from tendond.schemas.config_servo import BAUD_RATES, WATCHDOG_UNIT, ServoSection

SCAN_LAST_ID = 20
PORTS = ("ttyUSB*", "ttyACM*", "serial/by-id/*")
SETTLE_SECONDS = 0.3


@dataclass(frozen=True)
class Found:
    """A servo that answered."""

    port: str
    baudrate: int
    id: int
    model: int

    def __str__(self) -> str:
        name = table.MODEL_NAME if self.model == table.MODEL_NUMBER else f"model {self.model}"
        return f"{self.port}: {self.baudrate} bit/s, id {self.id}: {name}"


def ports(devices: Path = Path("/dev")) -> list[str]:
    """Serial adapters that are plugged in, each once."""
    found: dict[Path, str] = {}
    for pattern in PORTS:
        for path in sorted(devices.glob(pattern)):
            found.setdefault(path.resolve(), str(path))
    return list(found.values())


def scan(
    names: Sequence[str],
    answer_timeout: float,
    last_id: int = SCAN_LAST_ID,
    baudrates: Sequence[int] = BAUD_RATES,
    progress: Callable[[str], None] = lambda line: None,
) -> Iterator[Found]:
    """Ask every id at every rate on every port; nothing is moved or changed.

    Raises:
        PortLostError: the only port cannot be opened; of several, it is passed over and said.
    """
    for name in names:
        try:
            with ServoBus(name, baudrates[0], answer_timeout) as bus:
                for baudrate in baudrates:
                    progress(f"{name}: {baudrate} bit/s")
                    bus.set_baudrate(baudrate)
                    for identifier in range(last_id + 1):
                        model = bus.ping(identifier)
                        if model is not None:
                            yield Found(name, baudrate, identifier, model)
        except PortLostError as error:
            if len(names) == 1:
                raise
            progress(str(error))


def set_up(bus: ServoBus, old: int, new: int, baudrate: int) -> list[str]:
    """Give a servo its id, mode and rate; it must be still and alone with its old id. The rate comes last.

    Returns:
        What was changed.

    Raises:
        ServoError: it does not answer, is of another kind, or another servo has the new id already.
    """
    model = bus.ping(old)
    if model is None:
        raise ServoError(f"servo {old}: does not answer")
    if model != table.MODEL_NUMBER:
        raise ServoError(f"servo {old}: is model {model}, not {table.MODEL_NUMBER} ({table.MODEL_NAME})")
    if new != old and bus.ping(new) is not None:
        raise ServoError(f"servo {new}: there is one already on this bus")
    if bus.read(old, table.TORQUE_ENABLE):
        raise ServoError(f"servo {old}: its torque is on: switch its power off and on first")
    changed = []
    wanted = (
        (table.OPERATING_MODE, table.EXTENDED_POSITION),
        (table.DRIVE_MODE, 0),
        (table.STARTUP_CONFIGURATION, 0),
        (table.RETURN_DELAY_TIME, 0),
        (table.HOMING_OFFSET, 0),
        (table.ID, new),
        (table.BAUD_RATE, table.BAUD_CODES[baudrate]),
    )
    identifier = old
    for register, value in wanted:
        before = bus.read(identifier, register)
        if before == value:
            continue
        bus.write(identifier, register, value)
        changed.append(f"{register.name} {before} -> {value}")
        if register is table.ID:
            identifier = new
    if any(line.startswith(table.BAUD_RATE.name) for line in changed):
        bus.set_baudrate(baudrate)
    if bus.ping(identifier) is None:
        raise ServoError(f"servo {identifier}: does not answer any more after it was set up: run 'tendond servo scan'")
    return changed


class Motion:
    """One servo that is on, moved by goals; use `energised`."""

    def __init__(self, bus: ServoBus, section: ServoSection, spool: Spool) -> None:
        self._bus = bus
        self._section = section
        self.spool = spool
        self.id = spool.calibration.servo

    def look(self) -> Reading:
        """What the servo says now.

        Raises:
            ServoError: it does not answer, or has an error.
        """
        reading = self._bus.read_all((self.id,), fast=self._section.fast_read)[self.id]
        fault = standing_fault(self._section, (self.spool,), (reading,))
        if fault:
            raise ServoError(fault)
        return reading

    def move(self, target: float, load: float, stopped: Callable[[], bool]) -> Reading:
        """Wind slowly to a displacement, or until the load is reached.

        Args:
            target: [m].
            load: of the stall torque at which to stop [-].
            stopped: true when the operator has had enough.

        Raises:
            ServoError: an error of the servo, or it was stopped.
        """
        section = self._section
        reading = self.look()
        goal = self.spool.displacement(reading.position)
        last = time.monotonic()
        while True:
            now = time.monotonic()
            step = section.slow_rate * min(now - last, 2.0 * section.period)
            last = now
            goal = min(max(target, goal - step), goal + step)
            self._bus.write_all(table.GOAL_POSITION, {self.id: self.spool.ticks(goal)})
            reading = self.look()
            if not reading.torque or reading.watchdog == table.WATCHDOG_TRIPPED:
                raise ServoError(f"servo {self.id}: has lost its torque or was stopped by its watchdog")
            if abs(reading.load) * table.LOAD_UNIT >= load:
                return reading
            place = self.spool.displacement(reading.position)
            if goal == target and abs(place - target) < 1e-3:
                return reading
            if abs(place - goal) > section.following_error:
                raise ServoError(f"servo {self.id}: does not follow, {abs(place - goal) * 1e3:.1f} mm behind")
            if stopped():
                raise ServoError(f"servo {self.id}: stopped")
            time.sleep(section.period)

    def rest(self) -> Reading:
        """Stand still for a moment; what it says then."""
        until = time.monotonic() + SETTLE_SECONDS
        while time.monotonic() < until:
            reading = self.look()
            time.sleep(self._section.period)
        return reading


@contextmanager
def energised(bus: ServoBus, section: ServoSection, spool: Spool) -> Iterator[Motion]:
    """Torque on for one servo, slow and watched; off afterwards, whatever happens.

    Raises:
        ServoError: it has an error, refuses or does not answer.
    """
    identifier = spool.calibration.servo
    motion = Motion(bus, section, spool)
    reading = motion.look()
    speed = 2.0 * section.slow_rate / spool.calibration.spool_radius / table.VELOCITY_UNIT
    try:
        bus.write(identifier, table.BUS_WATCHDOG, 0)
        bus.write(identifier, table.PROFILE_VELOCITY, max(1, min(32767, round(speed))))
        bus.write(identifier, table.PROFILE_ACCELERATION, 0)
        bus.write(identifier, table.GOAL_POSITION, reading.position)
        bus.write(identifier, table.TORQUE_ENABLE, 1)
        bus.write(identifier, table.GOAL_POSITION, reading.position)
        bus.write(identifier, table.BUS_WATCHDOG, max(2, round(section.watchdog / WATCHDOG_UNIT)))
        yield motion
    finally:
        for _ in range(3):
            with suppress(ServoError):
                bus.write(identifier, table.TORQUE_ENABLE, 0)
                bus.write(identifier, table.BUS_WATCHDOG, 0)
                break


def home(
    bus: ServoBus, section: ServoSection, spool: Spool, stopped: Callable[[], bool] = lambda: False
) -> tuple[float, float]:
    """Bring a tendon slowly to its zero; the torque is off afterwards.

    Returns:
        Displacement before and after [m].

    Raises:
        ServoError: an error of the servo, a tendon that pulls before it is at zero, or it was stopped.
    """
    with energised(bus, section, spool) as motion:
        before = spool.displacement(motion.look().position)
        # Letting out, the load that is there goes away; winding up, there must be none: then zero is not where it was.
        reading = motion.move(0.0, 2.0 if before > 0.0 else 2.0 * section.pretension_load, stopped)
        after = spool.displacement(reading.position)
        if abs(after) > 1e-3:
            raise ServoError(
                f"servo {motion.id}: load {abs(reading.load) * table.LOAD_UNIT:.0%} at {after * 1e3:.1f} mm, stopped"
            )
    return before, after


def pretension(bus: ServoBus, section: ServoSection, spool: Spool, stopped: Callable[[], bool] = lambda: False) -> int:
    """Take up a tendon's slack: wind slowly until the load says that it pulls; the torque is off afterwards.

    Returns:
        Position at which it began to pull [ticks].

    Raises:
        ServoError: it pulls already, no load came within reach, an error of the servo, or it was stopped.
    """
    with energised(bus, section, spool) as motion:
        start = motion.rest()
        if abs(start.load) * table.LOAD_UNIT >= section.pretension_load:
            raise ServoError(
                f"servo {motion.id}: pulls already (load {abs(start.load) * table.LOAD_UNIT:.0%}): slacken it"
            )
        target = spool.displacement(start.position) + section.pretension_reach
        reading = motion.move(target, section.pretension_load, stopped)
        if abs(reading.load) * table.LOAD_UNIT < section.pretension_load:
            raise ServoError(
                f"servo {motion.id}: no load within {section.pretension_reach * 1e3:g} mm: is the tendon on its spool?"
            )
    return reading.position
