"""Limits and faults of the servo driver, independent of the controller. Reads no clock."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.reading import ServoReading
from tendond.drivers.dynamixel.spool import Spool
from tendond.drivers.dynamixel.strength import range_margin
from tendond.drivers.dynamixel.turns import Located
from tendond.schemas.config.servo import ServoSection

SUDDEN_LOAD = 0.15
"""Load above the limit that is a fault at once, as a fraction of the stall torque: 14 N on a spool of 15 mm."""

LOAD_RISE = 0.08
"""Allowed rise of a load during a release, as a fraction of the stall torque: 7.5 N on a spool of 15 mm, several times
the noise of an inferred load."""


def limited(
    section: ServoSection, wanted: Sequence[float], last: Sequence[float], duration: float
) -> tuple[float, ...]:
    """Limit goals to range and rate.

    Where a tendon would be too fast, all are slowed down by the same factor: antagonists that are a millimetre out of
    step pull at each other with tens of newtons.

    Args:
        section: [servo].
        wanted: displacement [m].
        last: goals of the cycle before [m].
        duration: since then [s]; limited to two periods, so that a late cycle makes no jump.
    """
    goals = tuple(min(max(goal, section.displacement_min), section.displacement_max) for goal in wanted)
    step = section.displacement_rate * min(duration, 2.0 * section.period)
    furthest = max(abs(goal - before) for goal, before in zip(goals, last, strict=True))
    if furthest <= step:
        return goals
    return tuple(before + step / furthest * (goal - before) for goal, before in zip(goals, last, strict=True))


def release_step(
    section: ServoSection,
    last: Sequence[float],
    duration: float,
    places: Sequence[float],
    taut: Sequence[bool],
) -> tuple[float, ...]:
    """Move the goals one step towards the straight robot.

    Tendons with a positive displacement are released; slack ones are taken up in proportion, and at `slow_rate` once no
    displacement is positive. A slack tendon that pulls waits until the robot has straightened.

    Args:
        section: [servo].
        last: goals of the cycle before [m].
        duration: since then [s].
        places: measured displacements [m].
        taut: which tendons pull.
    """
    duration = min(duration, 2.0 * section.period)
    step = min(section.release_rate, section.displacement_rate) * duration
    furthest = max(last)
    left = max(0.0, 1.0 - step / furthest) if furthest > 0.0 else 0.0
    slack_step = step if furthest > 0.0 else section.slow_rate * duration
    goals = []
    for goal, place, pulls in zip(last, places, taut, strict=True):
        if goal >= 0.0:
            goals.append(left * goal)
        elif pulls:
            goals.append(min(goal, place))
        else:
            goals.append(min(left * goal, goal + slack_step))
    return tuple(goals)


def standing_fault(section: ServoSection, spools: Sequence[Spool], readings: Sequence[ServoReading]) -> str:
    """Return the fault of servos with or without torque, in words; empty without one."""
    for spool, reading in zip(spools, readings, strict=True):
        servo = spool.calibration.servo
        if reading.trouble:
            return f"servo {servo}: {reading.trouble}"
        if reading.hardware_error:
            return f"servo {servo}: {', '.join(table.hardware_errors(reading.hardware_error))}"
        if reading.alert:
            return f"servo {servo}: hardware error"
        if reading.temperature > section.temperature_max:
            return f"servo {servo}: {reading.temperature} degrees, servo.temperature_max is {section.temperature_max:g}"
        volts = reading.voltage * table.VOLTAGE_UNIT
        if not section.voltage_min <= volts <= section.voltage_max:
            return f"servo {servo}: {volts:.1f} V, allowed: {section.voltage_min:g} to {section.voltage_max:g} V"
    return ""


def away_from_zero(section: ServoSection, located: Sequence[Located], readings: Sequence[ServoReading]) -> str:
    """Name a tendon too far from its zero to be switched on, or at an uncertain place; empty if there is none."""
    for index, (one, reading) in enumerate(zip(located, readings, strict=True)):
        name = f"tendon {index} (servo {one.spool.calibration.servo})"
        if one.doubt:
            return f"{name} {one.doubt}: measure it and run 'tendond servo home --at {index}=MM'"
        displacement = one.spool.displacement(reading.position)
        if abs(displacement) > section.home_window:
            return (
                f"{name} stands {displacement * 1e3:.1f} mm from its zero,"
                f" servo.home_window is {section.home_window * 1e3:g} mm: run 'tendond servo home'"
            )
    return ""


@dataclass
class ReleaseMonitor:
    """Loads during a release: one that rises belongs to a tendon that is pulled instead, or caught.

    Args:
        limits: largest load of each servo [-].
        sense: smallest load that is significant [-].
    """

    limits: Sequence[float]
    sense: float
    _first: dict[int, float] = field(default_factory=dict)

    def rising(self, loads: Sequence[float], goals: Sequence[float]) -> dict[int, str]:
        """Find tendons whose load is higher than at the start of the release; the reason in words, by index.

        A swinging rod loads a tendon again, but not above its first load. A slack tendon is taken up, and waits where
        it pulls: for it the limit applies.

        Args:
            loads: size of each servo's load [-].
            goals: goals of the tendons [m].
        """
        found = {}
        for index, (load, limit, goal) in enumerate(zip(loads, self.limits, goals, strict=True)):
            first = self._first.setdefault(index, load)
            if goal >= 0.0 and load > max(first, self.sense) + LOAD_RISE:
                found[index] = f"its load rises from {first:.0%} to {load:.0%} while it is released: is its sign right?"
            elif goal < 0.0 and load > max(limit, first):
                found[index] = f"load {load:.0%} while it is released, limit {limit:.0%}"
        return found


@dataclass
class Guard:
    """Faults of servos that are on: some immediate, some after a time.

    Args:
        section: [servo].
        watchdog: armed Bus Watchdog [units of its register].
        limits: largest load of each servo [-].
    """

    section: ServoSection
    watchdog: int
    limits: Sequence[float]
    _since: dict[str, float] = field(default_factory=dict)

    def fault(
        self, now: float, spools: Sequence[Spool], readings: Sequence[ServoReading], goals: Sequence[float]
    ) -> str:
        """Return the fault, in words; empty without one.

        Args:
            now: [s].
            spools: spools of the tendons.
            readings: readings of their servos.
            goals: sent before the reading [m].
        """
        fault = standing_fault(self.section, spools, readings)
        if fault:
            return fault
        section = self.section
        for index, (spool, reading, goal) in enumerate(zip(spools, readings, goals, strict=True)):
            servo = spool.calibration.servo
            if reading.watchdog == table.WATCHDOG_TRIPPED:
                return f"servo {servo}: its Bus Watchdog has stopped it"
            if not reading.torque:
                return f"servo {servo}: its torque is off: it has been rebooted or has lost power"
            if reading.watchdog != self.watchdog:
                return f"servo {servo}: its Bus Watchdog is {reading.watchdog}, not {self.watchdog}: was it rebooted?"
            place = spool.displacement(reading.position)
            margin = range_margin(spool.calibration.spool_radius, section.motor)
            if not section.displacement_min - margin <= place <= section.displacement_max + margin:
                return f"tendon {index} (servo {servo}): stands at {place * 1e3:.1f} mm, outside its range"
            load, limit = abs(reading.load) * table.LOAD_UNIT, self.limits[index]
            if self._lasts(f"sudden {index}", load > limit + SUDDEN_LOAD, now, 0.0):
                return f"tendon {index} (servo {servo}): load {load:.0%}, limit {limit:.0%}"
            if self._lasts(f"load {index}", load > limit, now, section.load_time):
                return f"tendon {index} (servo {servo}): load {load:.0%} for {section.load_time:g} s, limit {limit:.0%}"
            behind = abs(goal - place)
            if self._lasts(f"behind {index}", behind > section.following_error, now, section.following_time):
                return f"tendon {index} (servo {servo}): {behind * 1e3:.1f} mm from its goal: is it blocked?"
        return ""

    def _lasts(self, name: str, wrong: bool, now: float, allowed: float) -> bool:
        if not wrong:
            self._since.pop(name, None)
            return False
        return now - self._since.setdefault(name, now) > allowed
