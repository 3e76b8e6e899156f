"""The servo driver's own limits and faults by the number: pure functions of readings, goals and time."""

import dataclasses
from typing import Any

import pytest

from tendond.drivers.dynamixel.guard import let_out, limited, standing_fault
from tendond.drivers.dynamixel.reading import Reading
from tendond.drivers.dynamixel.spool import Spool
from tendond.schemas.config_servo import ServoSection
from tests.rig.servos import calibration

SECTION = ServoSection(
    period=0.01,
    displacement_min=-0.08,
    displacement_max=0.06,
    displacement_rate=0.08,
    release_rate=0.05,
    slow_rate=0.01,
    temperature_max=65.0,
    voltage_min=10.0,
    voltage_max=12.5,
)
SPOOLS = [Spool(one) for one in calibration().tendons[:2]]
WELL = Reading(
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


@pytest.mark.parametrize(
    ("last", "duration", "places", "taut", "goals"),
    [
        # 0.5 mm of 20 mm are let out, of the others as large a part
        ((0.02, 0.01, -0.01), 0.01, (0.0, 0.0, 0.0), (True, False, False), (0.0195, 0.00975, -0.00975)),
        ((0.02, 0.0, 0.0), 0.015, (0.0, 0.0, 0.0), (False, False, False), (0.01925, 0.0, 0.0)),
        ((0.02, 0.0, 0.0), 3.0, (0.0, 0.0, 0.0), (False, False, False), (0.019, 0.0, 0.0)),
        # half of 100 mm would be taken up in a cycle: no further than the step
        ((0.001, -0.1, 0.0), 0.01, (0.0, 0.0, 0.0), (False, False, False), (0.0005, -0.0995, 0.0)),
        # what pulls waits for the robot, and gives way to it
        ((0.02, -0.01, -0.01), 0.01, (0.0, -0.005, -0.02), (True, True, True), (0.0195, -0.01, -0.02)),
        # nothing is wound up any more: slowly
        ((0.0, -0.01, -0.00005), 0.01, (0.0, 0.0, 0.0), (False, False, False), (0.0, -0.0099, 0.0)),
        ((-0.003, -0.01, 0.0), 0.01, (-0.003, -0.012, 0.0), (True, True, False), (-0.003, -0.012, 0.0)),
        ((0.0004, 0.0, 0.0), 0.01, (0.0, 0.0, 0.0), (False, False, False), (0.0, 0.0, 0.0)),
    ],
)
def test_tendons_are_let_out_steadily_and_slack_is_taken_up_in_proportion(
    last: tuple[float, ...],
    duration: float,
    places: tuple[float, ...],
    taut: tuple[bool, ...],
    goals: tuple[float, ...],
) -> None:
    assert let_out(SECTION, last, duration, places, taut) == pytest.approx(goals, abs=1e-12)


def test_tendons_are_let_out_no_faster_than_the_servos_may_go() -> None:
    slow = SECTION.model_copy(update={"displacement_rate": 0.02})
    assert let_out(slow, (0.02,), 0.01, (0.0,), (False,)) == pytest.approx((0.0198,))


def test_values_of_another_number_of_servos_are_refused_and_not_cut() -> None:
    with pytest.raises(ValueError, match="zip"):
        limited(SECTION, (0.0, 0.0), (0.0,), 0.01)
    for arguments in (
        ((0.0,), 0.01, (0.0, 0.0), (True, True)),
        ((0.0, 0.0), 0.01, (0.0,), (True, True)),
        ((0.0, 0.0), 0.01, (0.0, 0.0), (True,)),
    ):
        with pytest.raises(ValueError, match="zip"):
            let_out(SECTION, *arguments)
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
        ({"voltage": 99}, "servo 2: 9.9 V, allowed are 10 to 12.5 V"),
        ({"voltage": 125}, ""),
        ({"voltage": 126}, "servo 2: 12.6 V, allowed are 10 to 12.5 V"),
    ],
)
def test_what_is_wrong_with_a_servo_as_it_stands_is_named(changes: dict[str, Any], fault: str) -> None:
    assert standing_fault(SECTION, SPOOLS, [WELL, dataclasses.replace(WELL, **changes)]) == fault
