"""Criteria of a rest and a motion, number by number: means, spreads, verdicts."""

import math

import numpy as np
import pytest

from tendond.daemon.control.commissioning.averages import EMPTY, ENOUGH, RESTLESS, STILL, Average, RestWatch
from tendond.daemon.control.commissioning.verdict import Bounds, Motion, agrees, judge
from tendond.schemas.base import Quaternion, Vector3

LEVEL: Quaternion = (1.0, 0.0, 0.0, 0.0)


def average(*positions: Vector3) -> Average:
    whole = EMPTY
    for position in positions:
        whole = whole.add(position, LEVEL)
    return whole


def test_an_average_is_the_mean_of_its_poses_and_its_spread_the_diagonal_of_their_box() -> None:
    one = average((1.0, -2.0, 3.0), (3.0, 2.0, 3.0), (2.0, 0.0, 9.0))
    assert one.count == 3
    assert one.mean.tolist() == [2.0, 0.0, 5.0]
    assert one.spread == pytest.approx(math.sqrt(2.0**2 + 4.0**2 + 6.0**2))
    assert average((1.0, -2.0, 3.0)).spread == 0.0


@pytest.mark.parametrize("component", [0, 1, 2, 3])
def test_orientations_of_either_sign_are_the_same(component: int) -> None:
    q = [0.5, 0.5, 0.5, 0.5]
    q[component] = 0.9
    size = math.sqrt(sum(value * value for value in q))
    w, x, y, z = (value / size for value in q)
    mean = EMPTY.add((0.0,) * 3, (w, x, y, z)).add((0.0,) * 3, (-w, -x, -y, -z)).add((0.0,) * 3, (w, x, y, z))
    assert mean.mean_orientation == pytest.approx((w, x, y, z))
    assert EMPTY.mean_orientation == LEVEL


def watch(*positions: Vector3 | None, block: int = 10) -> RestWatch:
    one = RESTLESS
    for position in positions:
        one = one.add(position, None if position is None else LEVEL, block)
    return one


HERE: Vector3 = (0.1, 0.2, 0.3)


def test_a_rest_is_judged_by_its_newest_block_once_that_has_poses_enough() -> None:
    there: Vector3 = (0.1, 0.2, 0.4)
    assert watch().best is None
    assert watch(None, None).best is None
    assert watch(HERE).best == average(HERE)
    whole = [HERE] * 10
    assert watch(*whole).before is None
    assert watch(*whole, *[there] * (ENOUGH - 1)).best == average(*whole)
    assert watch(*whole, *[there] * ENOUGH).best == average(*[there] * ENOUGH)
    assert watch(*whole, *[None] * 10, there).before is None  # a block without poses says nothing
    assert watch(*whole, *[None] * 10, there).best == average(there)


def test_a_tip_moves_that_spreads_or_drifts_by_more_than_a_hundredth_of_the_length() -> None:
    length = 0.5
    limit = STILL * length

    def at(x: float) -> Vector3:
        return (x, 0.0, 0.0)

    assert watch().moved(length) == 0.0
    assert watch(at(0.0), at(1.99 * limit)).moved(length) == 0.0
    assert watch(at(0.0), at(2.02 * limit)).moved(length) == pytest.approx(1.01 * limit)
    whole = [at(0.0)] * 10
    assert watch(*whole, at(0.99 * limit)).moved(length) == 0.0
    assert watch(*whole, at(1.01 * limit)).moved(length) == pytest.approx(1.01 * limit)
    swinging = [at(0.0), at(4.0 * limit)] * 5
    assert watch(*swinging, at(2.0 * limit)).moved(length) == pytest.approx(2.0 * limit)  # by the block before


BOUNDS = Bounds(angle=0.5, gain_min=0.6, gain_max=1.5, slack=0.001)
MOTION: Vector3 = (0.01, 0.0, 0.0)


def turned(angle: float, gain: float = 1.0) -> Vector3:
    return (0.01 * gain * math.cos(angle), 0.01 * gain * math.sin(angle), 0.0)


@pytest.mark.parametrize(
    ("motion", "passes"),
    [
        (Motion(MOTION, MOTION), True),
        (Motion(turned(0.49), MOTION), True),
        (Motion(turned(0.51), MOTION), False),
        (Motion(turned(-0.51), MOTION), False),
        (Motion(turned(0.0, 0.61), MOTION), True),
        (Motion(turned(0.0, 0.59), MOTION), False),
        (Motion(turned(0.0, 1.49), MOTION), True),
        (Motion(turned(0.0, 1.51), MOTION), False),
        (Motion((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), False),
        (Motion(MOTION, MOTION, 0.004, None), True),
        (Motion(MOTION, MOTION, 0.004, 0.0071), True),  # what the servo reports counts where the tip does not move
        (Motion(MOTION, MOTION, 0.004, 0.0009), True),
        (Motion(MOTION, MOTION, -0.004, -0.0071), True),
    ],
)
def test_a_tendon_passes_that_moves_the_tip_about_as_it_should(motion: Motion, passes: bool) -> None:
    assert agrees(motion, BOUNDS) is passes


MOTIONS: list[Vector3] = [(0.01, 0.0, 0.0), (0.0, 0.01, 0.0), (-0.01, 0.0, 0.0), (0.0, -0.01, 0.0)]


def verdict(*measured: Vector3 | None) -> str:
    return judge([Motion(one or expected, expected) for one, expected in zip(measured, MOTIONS, strict=True)], BOUNDS)


def swapped(*order: int) -> str:
    return verdict(*(MOTIONS[i] for i in order))


def test_a_verdict_tells_every_tendon_and_the_mistake_that_explains_them() -> None:
    assert verdict(None, None, None, None) == ""
    radius = "is its spool's radius, or the rod's stiffness, right?"
    assert verdict((0.02, 0.0, 0.0), None, None, None) == (
        f"tendon 0 moves the tip 2.0 times as far as it should: {radius}"
    )
    assert verdict(None, turned(math.pi / 2.0 + math.radians(40.0)), None, None) == (
        "tendon 1 moves the tip 40 degrees off its direction"
    )
    assert verdict(None, None, None, (0.0, -0.0024, 0.0)) == (
        "tendon 3 does not move the tip (2.4 of 10.0 mm): wound the wrong way round, cut, slack, or not connected?"
    )
    assert swapped(0, 3, 2, 1) == (
        "tendon 1 moves the tip as tendon 3 should; tendon 3 moves the tip as tendon 1 should; are tendons 1 and 3 "
        "swapped?; or is the camera's frame mirrored in y?"
    )
    assert swapped(2, 1, 0, 3).endswith("are tendons 0 and 2 swapped?; or is the camera's frame mirrored in x?")
    assert swapped(1, 2, 3, 0) == (
        "tendon 0 moves the tip as tendon 1 should; tendon 1 moves the tip as tendon 2 should; tendon 2 moves the tip "
        "as tendon 3 should; and 1 more tendons; are the tendons connected in another order?; or is the camera's frame "
        "rotated by 90 degrees about z?"
    )
    assert swapped(3, 0, 1, 2).endswith("or is the camera's frame rotated by -90 degrees about z?")
    assert swapped(2, 3, 0, 1).endswith("or is the camera's frame rotated by 180 degrees about z?")
    assert swapped(1, 0, 3, 2).endswith("or is the camera's frame one with x and y swapped?")
    nothing = verdict(*[(0.0, 0.0, 0.0)] * 4)
    assert nothing.endswith("and 1 more tendons; is the power of the servos on, and the arm free?")
    dead = (0.0, 0.0, 0.0)
    still = [
        Motion(dead, expected, 0.004, 0.0001) if index == 2 else Motion(expected, expected, 0.004, 0.004)
        for index, expected in enumerate(MOTIONS)
    ]
    assert judge(still, BOUNDS).startswith("tendon 2 reports 0.1 mm where 4.0 mm are commanded: does its servo turn?")


def test_a_motion_that_was_broken_off_is_judged_only_if_it_is_another_tendons() -> None:
    arms = [np.array(expected) for expected in MOTIONS]
    far: Vector3 = (0.03, 0.0, 0.0)
    assert judge([Motion(far, MOTIONS[0])], BOUNDS, arms, finished=False) == ""
    other: Vector3 = (0.0, 0.03, 0.0)
    assert judge([Motion(other, MOTIONS[0])], BOUNDS, arms, finished=False) == (
        "tendon 0 moves the tip as tendon 1 should; or is the camera's frame rotated by 90 degrees about z?"
    )
