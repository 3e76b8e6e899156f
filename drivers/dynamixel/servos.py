"""The servos of a rig as one thing: set up, on, off, goals, readings."""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress

from tendond.drivers.dynamixel.calibration import Calibration
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import TRIES, NoAnswerError, ServoBus, ServoError
from tendond.drivers.dynamixel.serial.reading import Reading
from tendond.drivers.dynamixel.spool import Spool
from tendond.drivers.dynamixel.strength import goal_pwm, load_limit
from tendond.drivers.dynamixel.tools.requirements import require
from tendond.drivers.dynamixel.turns import locate
from tendond.schemas.config.servo import WATCHDOG_UNIT, ServoSection

PWM_STEP = 18
"""[units of Goal PWM] A change that is worth a packet: 2 % of all."""

REBOOT_PINGS = 250
"""Tries in which a servo must be there again after a reboot; each takes an answer's timeout, 1 s in all by default."""


class Servos:
    """Servos on an open bus.

    Args:
        section: [servo].
        calibration: complete.
        bus: open.
        last: displacement at which each tendon was last known to be, by servo id [m].
        tension_max: of [limits] [N].

    Raises:
        ServoError: a servo is missing, of another kind, not set up, or has counted too many turns.

    Attributes:
        located: where each tendon is, and whether that is certain.
        spools: of the tendons, with the turns as the servos count them.
        watchdog: to be armed [units of its register].
        limits: load that each servo may have [-].
    """

    def __init__(
        self,
        section: ServoSection,
        calibration: Calibration,
        bus: ServoBus,
        last: Mapping[int, float] | None = None,
        tension_max: float = math.inf,
    ) -> None:
        self._section = section
        self._bus = bus
        self.ids = tuple(tendon.servo for tendon in calibration.tendons)
        self.watchdog = watchdog_units(section)
        self.limits = tuple(load_limit(section, tension_max, one.spool_radius) for one in calibration.tendons)
        for tendon in calibration.tendons:
            if objection := section.turn_objection(tendon.spool_radius, f"tendon {tendon.servo}'s spool_radius"):
                raise ServoError(f"servo {tendon.servo}: {objection}")
        find(bus, self.ids)
        require(bus, self.ids, section.answer_timeout)
        readings = self._first()
        self._tendons = calibration.tendons
        self.locate(readings, last or {})
        for spool in self.spools:
            within_range(section, spool)

    def locate(self, readings: Sequence[Reading], last: Mapping[int, float]) -> None:
        """Find each servo's turn.

        Args:
            readings: of the servos.
            last: displacement at which each tendon was last known to be, by servo id [m].
        """
        self.located = tuple(
            locate(self._section, tendon, reading.position, last.get(tendon.servo))
            for tendon, reading in zip(self._tendons, readings, strict=True)
        )
        self.spools: tuple[Spool, ...] = tuple(one.spool for one in self.located)

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
        here = {identifier: reading.position for identifier, reading in zip(self.ids, readings, strict=True)}
        try:
            for identifier in self.ids:
                self._bus.write(identifier, table.BUS_WATCHDOG, 0)
                self._write_profile(identifier)
            self.bound([0.0] * len(self.ids), readings)
            self._bus.write_all(table.GOAL_POSITION, here)  # before the torque: an old goal would be run to
            self._bus.write_all(table.TORQUE_ENABLE, dict.fromkeys(self.ids, 1))
            self._bus.write_all(table.GOAL_POSITION, here)
            self._bus.write_all(table.BUS_WATCHDOG, dict.fromkeys(self.ids, self.watchdog))
        except ServoError:
            with suppress(ServoError):
                self.off()
            raise

    def _write_profile(self, identifier: int) -> None:
        section = self._section
        velocity = max(1, int(section.profile_velocity / table.VELOCITY_UNIT))
        acceleration = round(section.profile_acceleration / table.ACCELERATION_UNIT)
        if section.profile_acceleration > 0.0:
            acceleration = max(1, acceleration)
        self._bus.write(identifier, table.PROFILE_VELOCITY, min(velocity, 32767))
        self._bus.write(identifier, table.PROFILE_ACCELERATION, min(acceleration, 32767))

    def bound(self, rates: Sequence[float], readings: Sequence[Reading]) -> None:
        """Bound what the motors put out, by the load that is allowed and the rate that is wanted.

        Args:
            rates: of the tendons [m/s].
            readings: the newest; where they have the right bound already, nothing is sent.

        Raises:
            ServoError: the packet did not go out.
        """
        wanted = {}
        for spool, limit, rate, reading in zip(self.spools, self.limits, rates, readings, strict=True):
            servo = spool.calibration
            pwm = goal_pwm(limit, servo.spool_radius, rate, reading.voltage * table.VOLTAGE_UNIT)
            if abs(pwm - reading.goal_pwm) >= PWM_STEP or (pwm == table.FULL_PWM != reading.goal_pwm):
                wanted[servo.servo] = pwm
        if wanted:
            self._bus.write_all(table.GOAL_PWM, wanted)

    def wake(self, readings: Sequence[Reading]) -> None:
        """Take over servos that their watchdog has stopped: profiles anew, which it cleared, goals where they stand.

        Raises:
            ServoError: a servo refuses or does not answer.
        """
        here = {identifier: reading.position for identifier, reading in zip(self.ids, readings, strict=True)}
        for identifier in self.ids:
            self._bus.write(identifier, table.BUS_WATCHDOG, 0)
            self._write_profile(identifier)
        self._bus.write_all(table.GOAL_POSITION, here)
        self._bus.write_all(table.BUS_WATCHDOG, dict.fromkeys(self.ids, self.watchdog))

    def drop(self, index: int) -> None:
        """Torque off for one tendon alone.

        Raises:
            ServoError: it does not say that it is off.
        """
        self._bus.write(self.ids[index], table.TORQUE_ENABLE, 0)

    def reboot(self, identifiers: Sequence[int]) -> None:
        """Start servos anew and wait until they are there again; they forget hardware errors and whole turns.

        Raises:
            ServoError: one does not answer afterwards.
        """
        for identifier in identifiers:
            self._bus.reboot(identifier)
        find(self._bus, identifiers, REBOOT_PINGS)

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


def find(bus: ServoBus, identifiers: Sequence[int], tries: int = TRIES) -> None:
    """See that servos are there.

    Raises:
        NoAnswerError: one is not, and what to do.
    """
    missing = bus.absent(identifiers, tries)
    if missing:
        names = ", ".join(map(str, missing))
        raise NoAnswerError(
            f"{bus.port}: no answer from servo {names}: is it powered, and its id and rate right? Try"
            f" 'tendond servo scan'{bus.lateness}"
        )


def watchdog_units(section: ServoSection) -> int:
    """`servo.watchdog` in units of the Bus Watchdog."""
    return max(2, round(section.watchdog / WATCHDOG_UNIT))


def within_range(section: ServoSection, spool: Spool) -> None:
    """See that a servo can take every goal of the travel.

    Raises:
        ServoError: it counts so many turns that it cannot: 256 are the most.
    """
    for displacement in (section.displacement_min, section.displacement_max):
        ticks = spool.ticks(displacement)
        if not table.GOAL_POSITION.least <= ticks <= table.GOAL_POSITION.most:
            raise ServoError(
                f"servo {spool.calibration.servo}: counts {spool.turns} turns, with the travel more than the 256 that"
                " it takes as a goal: switch its power off and on"
            )
