"""Open bus with servos that are set up: readings, goals, monitors. Reads no clock."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress

from tendond.drivers.dynamixel.calibration import Calibration
from tendond.drivers.dynamixel.driver.guard import (
    Guard,
    ReleaseMonitor,
    away_from_zero,
    release_step,
    standing_fault,
)
from tendond.drivers.dynamixel.driver.motors import GroupMaker, MotorBus
from tendond.drivers.dynamixel.driver.output import OutputRates
from tendond.drivers.dynamixel.driver.readings import TendonReadings
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import ServoError
from tendond.drivers.dynamixel.servos import ServoGroup
from tendond.drivers.dynamixel.strength import range_margin, speed_share
from tendond.schemas.config.servo import ServoSection


class ServoSession:
    """Servos of a rig from the opening of the port to its loss.

    Args:
        section: [servo].
        calibration: complete.
        open_bus: opens the port.
        places: last known displacement of each tendon, by servo id [m]; kept up to date.
        tension_max: limits.tension_max [N]; limits loads and motor output.
        make_group: makes the servos of the bus, or other motors.

    Raises:
        ServoError: the port cannot be opened, or the servos are not set up; the port is closed.

    Attributes:
        bus: open.
        servos: servos on the bus.
        readings: newest readings of the servos.
        goals: displacement of each tendon that is commanded [m].
        dropped: tendons that lost their torque during a release, with the reason, by index.
    """

    def __init__(
        self,
        section: ServoSection,
        calibration: Calibration,
        open_bus: Callable[[], MotorBus],
        places: dict[int, float],
        tension_max: float,
        make_group: GroupMaker = ServoGroup,
    ) -> None:
        self._section = section
        self.bus = open_bus()
        try:
            self.servos = make_group(section, calibration, self.bus, places, tension_max)
            self.readings = TendonReadings(self.servos, places)
        except ServoError:
            self.bus.close()
            raise
        self.goals = self.readings.displacement
        self._output = OutputRates(section.displacement_rate, self.goals)
        self.reset_monitors()

    def reset_monitors(self) -> None:
        """Monitor from now on, without any history."""
        self._guard = Guard(self._section, self.servos.watchdog, self.servos.limits)
        self._release = ReleaseMonitor(self.servos.limits, self._section.pretension_load)
        self._output.reset()
        self._rates = (0.0,) * len(self.servos.ids)
        self.readings.reset_speed()
        self.dropped: dict[int, str] = {}

    def stand_still(self) -> None:
        """Set the goals to where the tendons are, without sending them."""
        self.goals = self.readings.displacement
        self._output.restart(self.goals)

    def send(self, duration: float) -> None:
        """Send the goals, and the motor output that they need.

        Args:
            duration: since the last goals [s].

        Raises:
            ServoError: they were not sent.
        """
        self._rates = self._output.allowed(self.goals, duration, self.readings.speed)
        self._bound_output(self._speed_shares())
        self.servos.go(self.goals)

    def limit_output(self) -> None:
        """Take output from motors whose load asks for it, as soon as it has been read.

        Raises:
            ServoError: the packet was not sent.
        """
        shares = self._speed_shares()
        if min(shares) < 1.0:
            self._bound_output(shares)

    def _speed_shares(self) -> tuple[float, ...]:
        readings, limits = self.readings, self.servos.limits
        return tuple(map(speed_share, readings.loads, readings.rise, limits))

    def _bound_output(self, shares: Sequence[float]) -> None:
        rates = tuple(rate * share for rate, share in zip(self._rates, shares, strict=True))
        self.servos.bound(rates, self.readings.servo)

    def stop(self) -> None:
        """Stop all tendons where they are, within their range; a failure shows in the next cycle."""
        section, readings = self._section, self.readings
        self.goals = tuple(
            min(max(place, section.displacement_min), section.displacement_max) for place in readings.displacement
        )
        with suppress(ServoError):
            if any(reading.watchdog == table.WATCHDOG_TRIPPED for reading in readings.servo):
                self.servos.wake(readings.servo)  # else they would refuse to release
            self.servos.go(self.goals)

    def wake(self) -> None:
        """Take over servos that were stopped by their watchdog: they hold where they are.

        Raises:
            ServoError: a servo refuses or does not reply.
        """
        self.servos.wake(self.readings.servo)
        self.reset_monitors()
        self.stand_still()

    @property
    def holds(self) -> bool:
        """True where any servo has torque."""
        return any(reading.torque for reading in self.readings.servo)

    def objection(self) -> str:
        """Explain why the servos cannot be switched on, in words; empty where they can."""
        readings = self.readings.servo
        standing = standing_fault(self._section, self.servos.spools, readings)
        return standing or away_from_zero(self._section, self.servos.located, readings)

    def fault(self, now: float) -> str:
        """Return the fault of servos that are on, in words; empty without one.

        Args:
            now: [s].
        """
        return self._guard.fault(now, self.servos.spools, self.readings.servo, self.goals)

    @property
    def overloaded(self) -> bool:
        """True where a load is above its limit."""
        return any(load > limit for load, limit in zip(self.readings.loads, self.servos.limits, strict=True))

    def step_release(self, duration: float) -> bool:
        """Move the goals one step towards release; true once all tendons are released.

        Args:
            duration: since the last goals [s].
        """
        taut = [load > self._section.pretension_load for load in self.readings.loads]
        before, places = self.goals, self.readings.displacement
        self.goals = release_step(self._section, self.goals, duration, places, taut)
        margins = [range_margin(one.calibration.spool_radius, self._section.motor) for one in self.servos.spools]
        held = [index for index in range(len(places)) if index not in self.dropped]
        return self.goals == before and all(places[index] < margins[index] for index in held)

    def drop_rising(self) -> Iterator[str]:
        """Switch off the tendons whose load rises during a release; yield the reason, in words, before each.

        Raises:
            ServoError: one does not confirm it.
        """
        for index, why in self._release.rising(self.readings.loads, self.goals).items():
            if index in self.dropped or not self.readings.servo[index].torque:
                continue
            self.dropped[index] = f"tendon {index} (servo {self.servos.ids[index]}): {why}"
            yield self.dropped[index]
            self.servos.drop(index)
