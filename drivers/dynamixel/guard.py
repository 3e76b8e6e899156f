"""What the servo driver allows and what it takes for a fault, whatever the controller thinks. Reads no clock."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.reading import Reading
from tendond.drivers.dynamixel.spool import Spool
from tendond.drivers.dynamixel.turns import Located
from tendond.schemas.config.servo import ServoSection

SLIP = 0.002
"""[m] by which a tendon may be outside its range before that is a fault."""

SUDDEN = 0.15
"""Of the stall torque, beyond the limit, that is no matter of time any more: 14 N on a spool of 15 mm."""

RISE = 0.08
"""Of the stall torque, by which a load may rise while its tendon is let out: 7.5 N on a spool of 15 mm, some times
what an inferred load wavers."""


def limited(
    section: ServoSection, wanted: Sequence[float], last: Sequence[float], duration: float
) -> tuple[float, ...]:
    """Goals within range and rate.

    Where a tendon would be too fast, all are slowed down alike: tendons that work against each other and are a
    millimetre out of step pull at each other with tens of newtons.

    Args:
        section: [servo].
        wanted: displacement [m].
        last: goals of the cycle before [m].
        duration: since then [s]; more than two periods count as two, so that a late cycle makes no jump.
    """
    goals = tuple(min(max(goal, section.displacement_min), section.displacement_max) for goal in wanted)
    step = section.displacement_rate * min(duration, 2.0 * section.period)
    furthest = max(abs(goal - before) for goal, before in zip(goals, last, strict=True))
    if furthest <= step:
        return goals
    return tuple(before + step / furthest * (goal - before) for goal, before in zip(goals, last, strict=True))


def let_out(
    section: ServoSection,
    last: Sequence[float],
    duration: float,
    places: Sequence[float],
    taut: Sequence[bool],
) -> tuple[float, ...]:
    """Goals one step nearer to the straight robot's.

    What is wound up is let out; what was let out takes up its slack in proportion, and slowly once nothing is wound up
    any more. While it pulls it waits: the robot has not straightened so far.

    Args:
        section: [servo].
        last: goals of the cycle before [m].
        duration: since then [s].
        places: displacements as they are [m].
        taut: which tendons pull.
    """
    duration = min(duration, 2.0 * section.period)
    step = min(section.release_rate, section.displacement_rate) * duration
    wound = max(last)
    left = max(0.0, 1.0 - step / wound) if wound > 0.0 else 0.0
    slack_step = step if wound > 0.0 else section.slow_rate * duration
    goals = []
    for goal, place, pulls in zip(last, places, taut, strict=True):
        if goal >= 0.0:
            goals.append(left * goal)
        elif pulls:
            goals.append(min(goal, place))
        else:
            goals.append(min(left * goal, goal + slack_step))
    return tuple(goals)


def standing_fault(section: ServoSection, spools: Sequence[Spool], readings: Sequence[Reading]) -> str:
    """What is wrong with servos as they stand, with or without torque, in words; empty if nothing."""
    for spool, reading in zip(spools, readings, strict=True):
        servo = spool.calibration.servo
        if reading.hardware_error:
            return f"servo {servo}: {', '.join(table.hardware_errors(reading.hardware_error))}"
        if reading.alert:
            return f"servo {servo}: hardware error"
        if reading.temperature > section.temperature_max:
            return f"servo {servo}: {reading.temperature} degrees, servo.temperature_max is {section.temperature_max:g}"
        volts = reading.voltage * table.VOLTAGE_UNIT
        if not section.voltage_min <= volts <= section.voltage_max:
            return f"servo {servo}: {volts:.1f} V, allowed are {section.voltage_min:g} to {section.voltage_max:g} V"
    return ""


def away_from_zero(section: ServoSection, located: Sequence[Located], readings: Sequence[Reading]) -> str:
    """Which tendon stands too far from its zero to be switched on, or nobody knows where, in words; empty if none."""
    for index, (one, reading) in enumerate(zip(located, readings, strict=True)):
        name = f"tendon {index} (servo {one.spool.calibration.servo})"
        if one.doubt:
            return f"{name} {one.doubt}: look, and say it: 'tendond servo home --at {index}=MM'"
        displacement = one.spool.displacement(reading.position)
        if abs(displacement) > section.home_window:
            return (
                f"{name} stands {displacement * 1e3:.1f} mm from its zero,"
                f" servo.home_window is {section.home_window * 1e3:g} mm: run 'tendond servo home'"
            )
    return ""


@dataclass
class ReleaseWatch:
    """Loads while tendons are let out: one that rises is a tendon that is wound up instead, or caught.

    Args:
        limits: load that each may have [-].
        sense: load from which on one is believed [-].
    """

    limits: Sequence[float]
    sense: float
    _first: dict[int, float] = field(default_factory=dict)

    def rising(self, loads: Sequence[float], goals: Sequence[float]) -> dict[int, str]:
        """Which tendons pull harder than when they began to be let out, and how, in words.

        A rod that swings loads a tendon again, but not beyond what it had. One that was let out further than straight
        takes up its slack, and waits where it pulls: of it no more than its limit is asked.

        Args:
            loads: size of each servo's load [-].
            goals: of the tendons [m].
        """
        found = {}
        for index, (load, limit, goal) in enumerate(zip(loads, self.limits, goals, strict=True)):
            first = self._first.setdefault(index, load)
            if goal >= 0.0 and load > max(first, self.sense) + RISE:
                found[index] = f"its load rises from {first:.0%} to {load:.0%} while it is let out: is its sign right?"
            elif goal < 0.0 and load > max(limit, first):
                found[index] = f"load {load:.0%} while it is let out, allowed are {limit:.0%}"
        return found


@dataclass
class Guard:
    """Faults of servos that are on: some at once, some after a time.

    Args:
        section: [servo].
        watchdog: that was armed [units of its register].
        limits: load that each servo may have [-].
    """

    section: ServoSection
    watchdog: int
    limits: Sequence[float]
    _since: dict[str, float] = field(default_factory=dict)

    def fault(self, now: float, spools: Sequence[Spool], readings: Sequence[Reading], goals: Sequence[float]) -> str:
        """What is wrong, in words; empty if nothing.

        Args:
            now: [s].
            spools: of the tendons.
            readings: of their servos.
            goals: that they were given before they were read [m].
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
            if not section.displacement_min - SLIP <= place <= section.displacement_max + SLIP:
                return f"tendon {index} (servo {servo}): stands at {place * 1e3:.1f} mm, outside its range"
            load, limit = abs(reading.load) * table.LOAD_UNIT, self.limits[index]
            if self._lasts(f"sudden {index}", load > limit + SUDDEN, now, 0.0):
                return f"tendon {index} (servo {servo}): load {load:.0%}, allowed are {limit:.0%}"
            if self._lasts(f"load {index}", load > limit, now, section.load_time):
                return (
                    f"tendon {index} (servo {servo}): load {load:.0%} for {section.load_time:g} s, allowed are"
                    f" {limit:.0%}"
                )
            behind = abs(goal - place)
            if self._lasts(f"behind {index}", behind > section.following_error, now, section.following_time):
                return f"tendon {index} (servo {servo}): {behind * 1e3:.1f} mm from its goal: is it blocked?"
        return ""

    def _lasts(self, name: str, wrong: bool, now: float, allowed: float) -> bool:
        if not wrong:
            self._since.pop(name, None)
            return False
        return now - self._since.setdefault(name, now) > allowed
