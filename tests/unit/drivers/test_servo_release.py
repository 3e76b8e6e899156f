"""Release of the tendons: steps towards the straight robot, and the loads that are allowed in them."""

import pytest

from tendond.drivers.dynamixel.driver.guard import ReleaseMonitor, release_step
from tests.unit.drivers.servo_section import SECTION

LOAD_MAX = (0.5, 0.4)


@pytest.mark.parametrize(
    ("last", "duration", "places", "taut", "goals"),
    [
        # 0.5 mm of 20 mm are released, of the others in proportion
        ((0.02, 0.01, -0.01), 0.01, (0.0, 0.0, 0.0), (True, False, False), (0.0195, 0.00975, -0.00975)),
        ((0.02, 0.0, 0.0), 0.015, (0.0, 0.0, 0.0), (False, False, False), (0.01925, 0.0, 0.0)),
        ((0.02, 0.0, 0.0), 3.0, (0.0, 0.0, 0.0), (False, False, False), (0.019, 0.0, 0.0)),
        # half of 100 mm would be taken up in a cycle: no further than the step
        ((0.001, -0.1, 0.0), 0.01, (0.0, 0.0, 0.0), (False, False, False), (0.0005, -0.0995, 0.0)),
        # a slack tendon that pulls waits for the robot, and yields to it
        ((0.02, -0.01, -0.01), 0.01, (0.0, -0.005, -0.02), (True, True, True), (0.0195, -0.01, -0.02)),
        # no displacement is positive any more: slowly
        ((0.0, -0.01, -0.00005), 0.01, (0.0, 0.0, 0.0), (False, False, False), (0.0, -0.0099, 0.0)),
        ((-0.003, -0.01, 0.0), 0.01, (-0.003, -0.012, 0.0), (True, True, False), (-0.003, -0.012, 0.0)),
        ((0.0004, 0.0, 0.0), 0.01, (0.0, 0.0, 0.0), (False, False, False), (0.0, 0.0, 0.0)),
    ],
)
def test_tendons_are_released_steadily_and_slack_is_taken_up_in_proportion(
    last: tuple[float, ...],
    duration: float,
    places: tuple[float, ...],
    taut: tuple[bool, ...],
    goals: tuple[float, ...],
) -> None:
    assert release_step(SECTION, last, duration, places, taut) == pytest.approx(goals, abs=1e-12)


def test_tendons_are_released_no_faster_than_the_servos_may_move() -> None:
    slow = SECTION.model_copy(update={"displacement_rate": 0.02})
    assert release_step(slow, (0.02,), 0.01, (0.0,), (False,)) == pytest.approx((0.0198,))


PULLED, RELEASED = [0.01, 0.01], [-0.01, -0.01]


def test_a_load_that_rises_while_its_tendon_is_released_is_named() -> None:
    watch = ReleaseMonitor(limits=LOAD_MAX, sense=0.06)
    assert watch.rising([0.2, 0.1], PULLED) == {}
    assert watch.rising([0.1, 0.02], PULLED) == {}  # the rod swings: it may come back to what it had, and a little more
    assert watch.rising([0.27, 0.17], PULLED) == {}
    assert watch.rising([0.27, 0.19], PULLED) == {
        1: "its load rises from 10% to 19% while it is released: is its sign right?"
    }
    assert watch.rising([0.29, 0.15], PULLED) == {
        0: "its load rises from 20% to 29% while it is released: is its sign right?"
    }


def test_a_load_that_is_too_small_to_be_believed_does_not_rise() -> None:
    watch = ReleaseMonitor(limits=LOAD_MAX, sense=0.06)
    assert watch.rising([0.0, 0.0], PULLED) == {}
    assert watch.rising([0.139, 0.0], PULLED) == {}
    assert list(watch.rising([0.141, 0.0], PULLED)) == [0]


def test_a_load_of_the_start_is_released_however_large() -> None:
    watch = ReleaseMonitor(limits=LOAD_MAX, sense=0.06)
    assert watch.rising([0.66, 0.98], PULLED) == {}
    assert watch.rising([0.66, 1.0], PULLED) == {}
    assert list(watch.rising([0.75, 0.9], PULLED)) == [0]
    with pytest.raises(ValueError, match="zip"):
        watch.rising([0.1], PULLED)


def test_a_tendon_that_takes_up_its_slack_may_pull_up_to_its_limit() -> None:
    watch = ReleaseMonitor(limits=LOAD_MAX, sense=0.06)
    assert watch.rising([0.0, 0.0], RELEASED) == {}
    assert watch.rising([0.49, 0.39], RELEASED) == {}
    assert watch.rising([0.49, 0.41], RELEASED) == {1: "load 41% while it is released, limit 40%"}
