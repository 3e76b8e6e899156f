"""One servo under torque, moved slowly by a tool, with the driver's checks."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from tendond.drivers.dynamixel.checks import watchdog_units, within_range
from tendond.drivers.dynamixel.driver.guard import LOAD_RISE, standing_fault
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import NoReplyError, ServoBus, ServoError
from tendond.drivers.dynamixel.serial.reading import ServoReading
from tendond.drivers.dynamixel.spool import Spool
from tendond.drivers.dynamixel.strength import arrival_distance, current_bound, goal_pwm, load_limit, range_margin
from tendond.drivers.dynamixel.tools.requirements import require
from tendond.schemas.config.servo import ServoSection

SETTLE_SECONDS = 0.3
"""Time for which a tendon stands still before its reading counts [s]. Chosen; `pytest
tests/rig/servo/tools` passes with it."""

BLIND_READS = 20
"""Minimum number of lost reads in a row that a tool tolerates, while the tendon stands still. Where a fifth of
the replies is lost, the probability of so many in a row is 1e-14."""


class ServoMotion:
    """Servo that is on, moved by goals; use `energised`.

    Args:
        bus: open.
        section: [servo].
        spool: spool of the tendon.
        limit: largest load [-].
    """

    def __init__(self, bus: ServoBus, section: ServoSection, spool: Spool, limit: float) -> None:
        self._bus = bus
        self._section = section
        self._limit = limit
        self._lost = 0
        self.spool = spool
        self.id = spool.calibration.servo
        self.latest = self._first()

    def _first(self) -> ServoReading:
        for _ in range(BLIND_READS - 1):
            with suppress(NoReplyError):
                return self._ask()
        return self._ask()

    def _ask(self) -> ServoReading:
        return self._bus.read_all((self.id,), fast=self._section.fast_read)[self.id]

    @property
    def displacement(self) -> float:
        """Displacement of the tendon at the latest reading [m]."""
        return self.spool.displacement(self.latest.position)

    @property
    def arrival(self) -> float:
        """Distance from its target at which the tendon has arrived [m]."""
        return arrival_distance(self._section, self.spool.calibration.spool_radius)

    def look(self) -> bool:
        """Read the servo; false where the reply is lost, which is tolerated as in the driver.

        Raises:
            ServoError: it does not reply several times in a row, or has an error.
        """
        try:
            self.latest = self._ask()
        except NoReplyError:
            self._lost += 1
            if self._lost >= max(BLIND_READS, self._section.silent_reads):
                raise
            return False
        self._lost = 0
        fault = standing_fault(self._section, (self.spool,), (self.latest,))
        if fault:
            raise ServoError(fault)
        return True

    def move(self, target: float, load: float, stopped: Callable[[], bool], rate: float | None = None) -> ServoReading:
        """Move slowly to a displacement, or until the load is reached.

        Args:
            target: [m].
            load: load of the stall torque at which to stop [-].
            stopped: true when the operator interrupts it.
            rate: [m/s]; default: `servo.slow_rate`.

        Raises:
            ServoError: an error of the servo, a load above its limit or one that rises during a release, or it was
                interrupted.
        """
        section = self._section
        speed = section.slow_rate if rate is None else rate
        goal = self.displacement
        lowest = self.load
        last = time.monotonic()
        while True:
            now = time.monotonic()
            if self._lost == 0:  # without readings it stands still
                step = speed * min(now - last, 2.0 * section.period)
                goal = min(max(target, goal - step), goal + step)
            last = now
            releasing = goal < self.displacement or target < goal
            self._bus.write_all(table.GOAL_POSITION, {self.id: self.spool.ticks(goal)})
            if self.look():
                lowest = min(lowest, self.load)
                self.judge(goal, lowest if releasing else None)
                if self.load >= load or (goal == target and abs(self.displacement - target) < self.arrival):
                    return self.latest
            if stopped():
                raise ServoError(f"servo {self.id}: stopped")
            time.sleep(section.period)

    @property
    def load(self) -> float:
        """Load at the latest reading, as a fraction of the stall torque [-]."""
        return abs(self.latest.load) * table.LOAD_UNIT

    def judge(self, goal: float, lowest: float | None = None) -> None:
        """Check torque, load and following error.

        Args:
            goal: [m].
            lowest: smallest load of a release so far [-]; none where it is no release.

        Raises:
            ServoError: one of them is wrong.
        """
        if not self.latest.torque or self.latest.watchdog == table.WATCHDOG_TRIPPED:
            raise ServoError(f"servo {self.id}: has lost its torque or was stopped by its watchdog")
        if lowest is not None and self.load > max(lowest, self._section.pretension_load) + LOAD_RISE:
            raise CaughtError(
                f"servo {self.id}: its load rises from {lowest:.0%} to {self.load:.0%} while it is released: is its"
                " sign right, the tendon free?"
            )
        if lowest is None and self.load > self._limit:
            raise ServoError(f"servo {self.id}: load {self.load:.0%}, limit {self._limit:.0%}")
        behind = abs(self.displacement - goal)
        if behind > self._section.following_error:
            raise ServoError(f"servo {self.id}: does not follow, {behind * 1e3:.1f} mm behind")

    def rest(self) -> ServoReading:
        """Stand still for a moment; return the reading afterwards."""
        until = time.monotonic() + SETTLE_SECONDS
        while time.monotonic() < until or self._lost:
            self.look()
            time.sleep(self._section.period)
        return self.latest

    def begin(self) -> None:
        """Switch the torque on at the present position, with profile, limited output and Bus Watchdog.

        Raises:
            ServoError: it refuses or does not reply.
        """
        section, write = self._section, self._bus.write
        radius = self.spool.calibration.spool_radius
        rate = 2.0 * max(section.slow_rate, section.release_rate)
        model, motor = self._bus.model, section.motor
        fastest = min(rate / radius, motor.velocity_limit)
        speed = max(1, min(model.entry(table.PROFILE_VELOCITY).maximum, round(fastest / model.velocity_unit)))
        volts = self.latest.voltage * table.VOLTAGE_UNIT
        write(self.id, table.BUS_WATCHDOG, 0)
        write(self.id, table.PROFILE_VELOCITY, speed)
        write(self.id, table.PROFILE_ACCELERATION, 0)
        if (bound := current_bound(section, self._limit)) is not None:
            write(self.id, table.GOAL_CURRENT, model.current_goal(bound))
        if not motor.continuous:
            write(self.id, table.GOAL_PWM, goal_pwm(self._limit, radius, rate, volts, motor))
        write(self.id, table.GOAL_POSITION, self.latest.position)
        write(self.id, table.TORQUE_ENABLE, 1)
        write(self.id, table.GOAL_POSITION, self.latest.position)
        write(self.id, table.BUS_WATCHDOG, watchdog_units(section))

    def release_step(self) -> None:
        """Release a pulled tendon after an error, as far as it goes, instead of dropping it."""
        if self.displacement <= range_margin(self.spool.calibration.spool_radius, self._section.motor):
            return
        with suppress(ServoError):
            self._lost = 0
            self.latest = self._first()
            if self.latest.watchdog == table.WATCHDOG_TRIPPED:
                self.begin()
            if self.latest.torque and not self.latest.alert:
                until = time.monotonic() + self._section.release_time
                self.move(0.0, 2.0, lambda: time.monotonic() > until, self._section.release_rate)


class CaughtError(ServoError):
    """Error of a load that rises during a release: the tendon becomes slack only without torque."""


@contextmanager
def energised(bus: ServoBus, section: ServoSection, spool: Spool, tension_max: float) -> Iterator[ServoMotion]:
    """Switch on one servo, slow and monitored; in every case release the tendon, then switch it off.

    Args:
        bus: open.
        section: [servo].
        spool: spool of the tendon.
        tension_max: limits.tension_max [N].

    Raises:
        ServoError: it has an error, is not set up, refuses or does not reply.
    """
    identifier = spool.calibration.servo
    require(bus, (identifier,), section)
    within_range(section, spool, bus.model)
    motion = ServoMotion(bus, section, spool, load_limit(section, tension_max, spool.calibration.spool_radius))
    motion.look()
    try:
        motion.begin()
        yield motion
    except CaughtError:
        raise
    except BaseException:
        motion.release_step()
        raise
    finally:
        for _ in range(3):
            with suppress(ServoError):
                bus.write(identifier, table.TORQUE_ENABLE, 0)
                bus.write(identifier, table.BUS_WATCHDOG, 0)
                break
