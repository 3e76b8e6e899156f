"""The servos of a rig as one thing: set up, on, off, goals, readings."""

from collections.abc import Sequence
from contextlib import suppress

from tendond.drivers.dynamixel import table
from tendond.drivers.dynamixel.bus import TRIES, NoAnswerError, Reading, ServoBus, ServoError
from tendond.drivers.dynamixel.calibration import Calibration
from tendond.drivers.dynamixel.spool import Spool
from tendond.drivers.dynamixel.table import Register
from tendond.schemas.config_servo import WATCHDOG_UNIT, ServoSection


class Servos:
    """Servos on an open bus.

    Args:
        section: [servo].
        calibration: complete.
        bus: open.

    Raises:
        ServoError: a servo is missing, of another kind, or not set up.

    Attributes:
        spools: of the tendons, with the turns as the servos count them.
        watchdog: to be armed [units of its register].
    """

    def __init__(self, section: ServoSection, calibration: Calibration, bus: ServoBus) -> None:
        self._section = section
        self._bus = bus
        self.spools: tuple[Spool, ...] = tuple(Spool(tendon) for tendon in calibration.tendons)
        self.ids = tuple(tendon.servo for tendon in calibration.tendons)
        self.watchdog = max(2, round(section.watchdog / WATCHDOG_UNIT))
        missing = bus.absent(self.ids)
        if missing:
            names = ", ".join(map(str, missing))
            raise NoAnswerError(
                f"{bus.port}: no answer from servo {names}: is it powered, and its id and rate right? Try"
                " 'tendond servo scan'"
            )
        for identifier in self.ids:
            self._require(identifier, table.MODEL, table.MODEL_NUMBER, f"is no {table.MODEL_NAME}")
            setup = "run 'tendond servo setup'"
            self._require(identifier, table.OPERATING_MODE, table.EXTENDED_POSITION, setup)
            self._require(identifier, table.DRIVE_MODE, 0, setup)  # else a goal might switch the torque on
            self._require(identifier, table.STARTUP_CONFIGURATION, 0, setup)  # or power-up might
        readings = self._first()
        self.spools = tuple(
            spool.at_power_up(reading.position) for spool, reading in zip(self.spools, readings, strict=True)
        )

    def _first(self) -> tuple[Reading, ...]:
        """The first reading: old firmware answers a plain one alone."""
        try:
            return self.read_again()
        except NoAnswerError:
            if self._section.fast_read:
                with suppress(NoAnswerError):
                    self._bus.read_all(self.ids, fast=False)
                    raise ServoError(
                        "the servos do not know Fast Sync Read, but the plain one: update their firmware, or set"
                        " servo.fast_read = false"
                    ) from None
            raise

    def _require(self, identifier: int, register: Register, wanted: int, remedy: str) -> None:
        found = self._bus.read(identifier, register)
        if found != wanted:
            raise ServoError(f"servo {identifier}: {register.name} is {found}, must be {wanted}: {remedy}")

    def read(self) -> tuple[Reading, ...]:
        """Of every servo, in the order of the tendons.

        Raises:
            ServoError: not all of them answered.
        """
        readings = self._bus.read_all(self.ids, fast=self._section.fast_read)
        return tuple(readings[identifier] for identifier in self.ids)

    def read_again(self) -> tuple[Reading, ...]:
        """As `read`, but one answer that gets lost is no error: for when nobody asks again a cycle later.

        Raises:
            ServoError: not all of them answered, several times.
        """
        for _ in range(TRIES - 1):
            with suppress(NoAnswerError):
                return self.read()
        return self.read()

    def on(self, readings: Sequence[Reading]) -> None:
        """Torque on where the servos stand, at the configured profile, watched.

        Raises:
            ServoError: a servo refuses or does not answer; all of them are off again.
        """
        velocity = max(1, int(self._section.profile_velocity / table.VELOCITY_UNIT))
        acceleration = round(self._section.profile_acceleration / table.ACCELERATION_UNIT)
        if self._section.profile_acceleration > 0.0:
            acceleration = max(1, acceleration)
        here = {identifier: reading.position for identifier, reading in zip(self.ids, readings, strict=True)}
        try:
            for identifier in self.ids:
                self._bus.write(identifier, table.BUS_WATCHDOG, 0)
                self._bus.write(identifier, table.PROFILE_VELOCITY, min(velocity, 32767))
                self._bus.write(identifier, table.PROFILE_ACCELERATION, min(acceleration, 32767))
            self._bus.write_all(table.GOAL_POSITION, here)  # before the torque: an old goal would be run to
            self._bus.write_all(table.TORQUE_ENABLE, dict.fromkeys(self.ids, 1))
            self._bus.write_all(table.GOAL_POSITION, here)
            self._bus.write_all(table.BUS_WATCHDOG, dict.fromkeys(self.ids, self.watchdog))
        except ServoError:
            with suppress(ServoError):
                self.off()
            raise

    def wake(self, readings: Sequence[Reading]) -> None:
        """Take over servos that their watchdog has stopped: goals where they stand, then watched again.

        Raises:
            ServoError: a servo refuses or does not answer.
        """
        here = {identifier: reading.position for identifier, reading in zip(self.ids, readings, strict=True)}
        self._bus.write_all(table.BUS_WATCHDOG, dict.fromkeys(self.ids, 0))
        self._bus.write_all(table.GOAL_POSITION, here)
        self._bus.write_all(table.BUS_WATCHDOG, dict.fromkeys(self.ids, self.watchdog))

    def go(self, goals: Sequence[float]) -> None:
        """Displacement that each tendon is to have [m].

        Raises:
            ServoError: the goals did not go out.
        """
        ticks = [spool.ticks(goal) for spool, goal in zip(self.spools, goals, strict=True)]
        self._bus.write_all(table.GOAL_POSITION, dict(zip(self.ids, ticks, strict=True)))

    def off(self) -> None:
        """Torque off: all of them in one packet, then each in the order of the tendons until it says so itself.

        Raises:
            ServoError: it cannot be told whether a servo is off; all the others are.
        """
        self._bus.write_all(table.TORQUE_ENABLE, dict.fromkeys(self.ids, 0))
        failed: ServoError | None = None
        for identifier in self.ids:
            try:
                self._bus.write(identifier, table.TORQUE_ENABLE, 0)
                self._bus.write(identifier, table.BUS_WATCHDOG, 0)
            except ServoError as error:
                failed = failed or error
        if failed is not None:
            raise failed

    def displacements(self, readings: Sequence[Reading]) -> tuple[float, ...]:
        """Of the tendons [m]."""
        return tuple(spool.displacement(reading.position) for spool, reading in zip(self.spools, readings, strict=True))

    def tensions(self, readings: Sequence[Reading]) -> tuple[float, ...]:
        """Of the tendons, as the servos estimate them [N]."""
        return tuple(spool.tension(reading.load) for spool, reading in zip(self.spools, readings, strict=True))
