"""The servo driver's own limits and faults by the number: pure functions of readings, goals and time."""

import dataclasses
from typing import Any

import pytest

from tendond.drivers.dynamixel.driver.guard import Guard, away_from_zero, limited, release_step, standing_fault
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.reading import ServoReading
from tendond.drivers.dynamixel.spool import Spool
from tendond.drivers.dynamixel.turns import Located
from tests.rig.servos import calibration
from tests.unit.drivers.servo_section import SECTION

SPOOLS = [Spool(one) for one in calibration().tendons[:2]]
WELL = ServoReading(
    torque=1, hardware_error=0, watchdog=10, goal=2048, load=0, position=2048, voltage=111, temperature=30, alert=False
)


@pytest.mark.parametrize(
    ("wanted", "last", "duration", "goals"),
    [
        ((0.0008, -0.0008), (0.0, 0.0), 0.01, (0.0008, -0.0008)),  # as fast as allowed
        ((0.06, -0.08), (0.06, -0.08), 0.01, (0.06, -0.08)),  # as far as allowed
        ((0.07, -0.09), (0.06, -0.08), 0.01, (0.06, -0.08)),
        ((0.02, -0.01), (0.0, 0.0), 0.01, (0.0008, -0.0004)),  # both slowed down alike
        ((-0.01, 0.02), (0.0, 0.01), 0.01, (-0.0008, 0.0108)),
        ((0.02, 0.0), (0.0, 0.0), 0.015, (0.0012, 0.0)),
        ((0.02, 0.0), (0.0, 0.0), 0.02, (0.0016, 0.0)),
        ((0.02, 0.0), (0.0, 0.0), 5.0, (0.0016, 0.0)),  # a late cycle makes no jump
    ],
)
def test_goals_are_within_range_and_rate_and_all_slowed_down_alike(
    wanted: tuple[float, ...], last: tuple[float, ...], duration: float, goals: tuple[float, ...]
) -> None:
    assert limited(SECTION, wanted, last, duration) == pytest.approx(goals, abs=1e-12)


def test_values_of_another_number_of_servos_are_refused_and_not_cut() -> None:
    with pytest.raises(ValueError, match="zip"):
        limited(SECTION, (0.0, 0.0), (0.0,), 0.01)
    for arguments in (
        ((0.0,), 0.01, (0.0, 0.0), (True, True)),
        ((0.0, 0.0), 0.01, (0.0,), (True, True)),
        ((0.0, 0.0), 0.01, (0.0, 0.0), (True,)),
    ):
        with pytest.raises(ValueError, match="zip"):
            release_step(SECTION, *arguments)
    with pytest.raises(ValueError, match="zip"):
        standing_fault(SECTION, SPOOLS, [WELL])


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({}, ""),
        ({"hardware_error": 0x20}, "servo 2: Overload Error (bit 5)"),
        ({"hardware_error": 0x24}, "servo 2: Overheating Error (bit 2), Overload Error (bit 5)"),
        ({"alert": True}, "servo 2: hardware error"),
        ({"temperature": 65}, ""),
        ({"temperature": 66}, "servo 2: 66 degrees, servo.temperature_max is 65"),
        ({"voltage": 100}, ""),
        ({"voltage": 99}, "servo 2: 9.9 V, allowed: 10 to 12.5 V"),
        ({"voltage": 125}, ""),
        ({"voltage": 126}, "servo 2: 12.6 V, allowed: 10 to 12.5 V"),
    ],
)
def test_what_is_wrong_with_a_servo_as_it_stands_is_named(changes: dict[str, Any], fault: str) -> None:
    assert standing_fault(SECTION, SPOOLS, [WELL, dataclasses.replace(WELL, **changes)]) == fault


def away(displacement: float, others: tuple[float, ...] = ()) -> str:
    """Return the message about the second of two tendons that stands at `displacement` [m]."""
    located = [Located(SPOOLS[0], 0.0), Located(SPOOLS[1], displacement, others)]
    readings = [WELL, dataclasses.replace(WELL, position=SPOOLS[1].ticks(displacement))]
    return away_from_zero(SECTION, located, readings)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_tendon_far_from_its_zero_is_not_switched_on(sign: float) -> None:
    assert away(sign * 0.0099) == ""
    assert away(sign * 0.0101) == (
        f"tendon 1 (servo 2) stands {sign * 10.1:.1f} mm from its zero, servo.home_window is 10 mm: run 'tendond servo "
        "home'"
    )


def test_a_tendon_of_uncertain_turn_is_not_switched_on() -> None:
    said = away(0.0, (0.094,))
    assert said.startswith("tendon 1 (servo 2) ")
    assert said.endswith(": measure it and run 'tendond servo home --at 1=MM'")
    with pytest.raises(ValueError, match="zip"):
        away_from_zero(SECTION, [Located(SPOOLS[0], 0.0)], [WELL, WELL])


LOAD_MAX = (0.5, 0.4)


class Watched:
    """A guard of two servos of which the second changes."""

    def __init__(self) -> None:
        self.guard = Guard(SECTION, watchdog=10, limits=LOAD_MAX)

    def fault(self, now: float = 0.0, goal: float = 0.0, place: float = 0.0, **changes: Any) -> str:
        second = dataclasses.replace(WELL, position=SPOOLS[1].ticks(place), **changes)
        return self.guard.fault(now, SPOOLS, [WELL, second], [0.0, goal])


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({}, ""),
        ({"hardware_error": 0x20}, "servo 2: Overload Error (bit 5)"),
        ({"watchdog": table.WATCHDOG_TRIPPED}, "servo 2: its Bus Watchdog has stopped it"),
        ({"torque": 0}, "servo 2: its torque is off: it has been rebooted or has lost power"),
        ({"watchdog": 0}, "servo 2: its Bus Watchdog is 0, not 10: was it rebooted?"),
        ({"watchdog": 11}, "servo 2: its Bus Watchdog is 11, not 10: was it rebooted?"),
        ({"place": 0.0619, "goal": 0.06}, ""),
        ({"place": 0.0621, "goal": 0.06}, "tendon 1 (servo 2): stands at 62.1 mm, outside its range"),
        ({"place": -0.0819, "goal": -0.08}, ""),
        ({"place": -0.0821, "goal": -0.08}, "tendon 1 (servo 2): stands at -82.1 mm, outside its range"),
    ],
)
def test_what_is_wrong_with_a_servo_that_is_on_is_named_at_once(changes: dict[str, Any], fault: str) -> None:
    assert Watched().fault(**changes) == fault


@pytest.mark.parametrize("sign", [1, -1])
def test_a_load_beyond_the_limit_of_its_own_servo_is_tolerated_for_a_time(sign: int) -> None:
    watched = Watched()
    assert watched.fault(100.0, load=sign * 450) == ""
    assert watched.fault(100.25, load=sign * 450) == ""
    assert watched.fault(100.26, load=sign * 450) == ("tendon 1 (servo 2): load 45% for 0.25 s, limit 40%")
    watched = Watched()
    watched.fault(100.0, load=sign * 450)
    assert watched.fault(100.2, load=sign * 400) == ""  # back at the limit: the time begins anew
    assert watched.fault(100.3, load=sign * 450) == ""
    assert watched.fault(100.55, load=sign * 450) == ""
    assert watched.fault(100.56, load=sign * 450) != ""


def test_a_sudden_load_is_tolerated_for_one_reading() -> None:
    watched = Watched()
    assert watched.fault(100.0, load=560) == ""
    assert watched.fault(100.01, load=560) == "tendon 1 (servo 2): load 56%, limit 40%"
    watched = Watched()
    assert watched.fault(100.0, load=550) == ""
    assert watched.fault(100.01, load=550) == ""


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_tendon_that_does_not_follow_its_goal_is_tolerated_for_a_time(sign: float) -> None:
    watched = Watched()
    assert watched.fault(100.0, goal=sign * 0.0103) == ""
    assert watched.fault(100.5, goal=sign * 0.0103) == ""
    assert watched.fault(100.51, goal=sign * 0.0103) == "tendon 1 (servo 2): 10.3 mm from its goal: is it blocked?"
    watched = Watched()
    for now in (100.0, 100.51, 102.0):
        assert watched.fault(now, goal=sign * 0.0099) == ""


def test_two_tendons_are_timed_each_for_itself() -> None:
    guard = Guard(SECTION, watchdog=10, limits=LOAD_MAX)
    behind, well = [0.02, 0.0], [0.0, 0.0]
    assert guard.fault(100.0, SPOOLS, [WELL, WELL], behind) == ""
    assert guard.fault(100.3, SPOOLS, [WELL, WELL], [0.0, 0.02]) == ""
    assert guard.fault(100.6, SPOOLS, [WELL, WELL], [0.0, 0.02]) == ""
    assert guard.fault(100.81, SPOOLS, [WELL, WELL], [0.0, 0.02]).startswith("tendon 1 ")
    for readings, goals in (([WELL], well), ([WELL, WELL], [0.0])):
        with pytest.raises(ValueError, match="zip"):
            guard.fault(101.0, SPOOLS, readings, goals)
