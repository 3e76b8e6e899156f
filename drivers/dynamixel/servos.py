"""Servos of a rig as a group: torque, goals, readings."""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress

from tendond.drivers.dynamixel.calibration import Calibration
from tendond.drivers.dynamixel.checks import find, profile_units, watchdog_units, within_range
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import TRIES, NoReplyError, ServoBus, ServoError
from tendond.drivers.dynamixel.serial.reading import ServoReading
from tendond.drivers.dynamixel.spool import Spool
from tendond.drivers.dynamixel.strength import current_bound, goal_pwm, load_limit
from tendond.drivers.dynamixel.tools.requirements import require
from tendond.drivers.dynamixel.turns import locate
from tendond.schemas.config.servo import ServoSection

PWM_STEP = 18
"""Smallest change of Goal PWM that is sent, 2 % of the range [units of the register]."""

REBOOT_PINGS = 250
"""Pings within which a servo must reply after a reboot, each with the reply's timeout: 1 s in all by default."""


class ServoGroup:
    """Servos of a rig on an open bus.

    Args:
        section: [servo].
        calibration: complete.
        bus: open.
        last: last known displacement of each tendon, by servo id [m].
        tension_max: limits.tension_max [N].

    Raises:
        ServoError: a servo is missing, of another model, not set up, or has counted too many turns.

    Attributes:
        located: place of each tendon, and whether it is certain.
        spools: spools of the tendons, with the turns of the servos.
        watchdog: Bus Watchdog to arm [units of its register].
        limits: largest load of each servo [-].
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
            if tendon.ticks_per_turn != section.motor.ticks_per_turn:
                raise ServoError(
                    f"servo {tendon.servo}: its calibration is of a servo with {tendon.ticks_per_turn} positions a"
                    f" turn, the {section.model} has {section.motor.ticks_per_turn}: run 'tendond servo calibrate'"
                )
            if objection := section.turn_objection(tendon.spool_radius, f"tendon {tendon.servo}'s spool_radius"):
                raise ServoError(f"servo {tendon.servo}: {objection}")
        find(bus, self.ids)
        require(bus, self.ids, section)
        readings = self._first()
        self._currents = {
            identifier: bus.model.current_goal(bound)
            for identifier, limit in zip(self.ids, self.limits, strict=True)
            if (bound := current_bound(section, limit)) is not None
        }
        self._tendons = calibration.tendons
        self.locate(readings, last or {})
        for spool in self.spools:
            within_range(section, spool, bus.model)

    def locate(self, readings: Sequence[ServoReading], last: Mapping[int, float]) -> None:
        """Find the turn of each servo.

        Args:
            readings: readings of the servos.
            last: last known displacement of each tendon, by servo id [m].
        """
        self.located = tuple(
            locate(self._section, tendon, reading.position, last.get(tendon.servo))
            for tendon, reading in zip(self._tendons, readings, strict=True)
        )
        self.spools: tuple[Spool, ...] = tuple(one.spool for one in self.located)

    def _first(self) -> tuple[ServoReading, ...]:
        """Read for the first time; explain where old firmware replies only to a plain Sync Read."""
        try:
            return self.read_again()
        except NoReplyError:
            if self._section.fast_read:
                with suppress(NoReplyError):
                    self._bus.read_all(self.ids, fast=False)
                    raise ServoError(
                        "the servos do not know Fast Sync Read, only Sync Read: update their firmware, or set"
                        " servo.fast_read = false"
                    ) from None
            raise

    def read(self) -> tuple[ServoReading, ...]:
        """Read all servos, in the order of the tendons.

        Raises:
            ServoError: not all of them replied.
        """
        readings = self._bus.read_all(self.ids, fast=self._section.fast_read)
        return tuple(readings[identifier] for identifier in self.ids)

    def read_again(self) -> tuple[ServoReading, ...]:
        """Read all servos, again where a reply is lost: for reads that are not repeated in the next cycle.

        Raises:
            ServoError: not all of them replied, several times.
        """
        for _ in range(TRIES - 1):
            with suppress(NoReplyError):
                return self.read()
        return self.read()

    def on(self, readings: Sequence[ServoReading]) -> None:
        """Switch the torque on at the present positions, with the configured profile and watchdog.

        Raises:
            ServoError: a servo refuses or does not reply; all of them are off again.
        """
        here = {identifier: reading.position for identifier, reading in zip(self.ids, readings, strict=True)}
        try:
            for identifier in self.ids:
                self._bus.write(identifier, table.BUS_WATCHDOG, 0)
                self._write_profile(identifier)
            for identifier, current in self._currents.items():
                self._bus.write(identifier, table.GOAL_CURRENT, current)
            self.bound([0.0] * len(self.ids), readings)
            self._bus.write_all(table.GOAL_POSITION, here)  # before the torque, or the servos would move to an old goal
            self._bus.write_all(table.TORQUE_ENABLE, dict.fromkeys(self.ids, 1))
            self._bus.write_all(table.GOAL_POSITION, here)
            self._bus.write_all(table.BUS_WATCHDOG, dict.fromkeys(self.ids, self.watchdog))
        except ServoError:
            with suppress(ServoError):
                self.off()
            raise

    def _write_profile(self, identifier: int) -> None:
        section = self._section
        velocity, acceleration = profile_units(self._bus.model, section)
        self._bus.write(identifier, table.PROFILE_VELOCITY, velocity)
        self._bus.write(identifier, table.PROFILE_ACCELERATION, acceleration)

    def bound(self, rates: Sequence[float], readings: Sequence[ServoReading]) -> None:
        """Limit the output of the motors to the allowed load and rate.

        Args:
            rates: rates of the tendons [m/s].
            readings: newest; nothing is sent where they have that limit already.

        Raises:
            ServoError: the packet was not sent.
        """
        motor, wanted = self._section.motor, {}
        for spool, limit, rate, reading in zip(self.spools, self.limits, rates, readings, strict=True):
            servo = spool.calibration
            pwm = self._bus.model.full_pwm
            if not motor.continuous:
                pwm = goal_pwm(limit, servo.spool_radius, rate, reading.voltage * table.VOLTAGE_UNIT, motor)
            if abs(pwm - reading.goal_pwm) >= PWM_STEP or (pwm == self._bus.model.full_pwm != reading.goal_pwm):
                wanted[servo.servo] = pwm
        if wanted:
            self._bus.write_all(table.GOAL_PWM, wanted)
        lost = {
            identifier: self._currents[identifier]
            for identifier, reading in zip(self.ids, readings, strict=True)
            if self._currents.get(identifier, reading.goal_current) != reading.goal_current
        }
        if lost:
            self._bus.write_all(table.GOAL_CURRENT, lost)

    def wake(self, readings: Sequence[ServoReading]) -> None:
        """Take over servos stopped by their watchdog: restore their profiles, hold their positions.

        Raises:
            ServoError: a servo refuses or does not reply.
        """
        here = {identifier: reading.position for identifier, reading in zip(self.ids, readings, strict=True)}
        for identifier in self.ids:
            self._bus.write(identifier, table.BUS_WATCHDOG, 0)
            self._write_profile(identifier)
        self._bus.write_all(table.GOAL_POSITION, here)
        self._bus.write_all(table.BUS_WATCHDOG, dict.fromkeys(self.ids, self.watchdog))

    def drop(self, index: int) -> None:
        """Switch off the torque of one tendon.

        Raises:
            ServoError: its servo does not confirm it.
        """
        self._bus.write(self.ids[index], table.TORQUE_ENABLE, 0)

    def reboot(self, identifiers: Sequence[int]) -> None:
        """Reboot servos and wait for them; hardware errors and whole turns are lost.

        Raises:
            ServoError: one does not reply afterwards.
        """
        for identifier in identifiers:
            self._bus.reboot(identifier)
        find(self._bus, identifiers, REBOOT_PINGS)

    def go(self, goals: Sequence[float]) -> None:
        """Send the goal of each tendon [m].

        Raises:
            ServoError: the goals were not sent.
        """
        ticks = [spool.ticks(goal) for spool, goal in zip(self.spools, goals, strict=True)]
        self._bus.write_all(table.GOAL_POSITION, dict(zip(self.ids, ticks, strict=True)))

    def off(self) -> None:
        """Switch the torque off: all in one packet, then each in the order of the tendons, confirmed.

        Raises:
            ServoError: a servo does not confirm it; all the others are off.
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

    def displacements(self, readings: Sequence[ServoReading]) -> tuple[float, ...]:
        """Return the displacement of each tendon [m]."""
        return tuple(spool.displacement(reading.position) for spool, reading in zip(self.spools, readings, strict=True))

    def tensions(self, readings: Sequence[ServoReading]) -> tuple[float, ...]:
        """Return the tension of each tendon, as the servos estimate it [N]."""
        return tuple(
            spool.tension(reading.load, self._section.motor)
            for spool, reading in zip(self.spools, readings, strict=True)
        )
