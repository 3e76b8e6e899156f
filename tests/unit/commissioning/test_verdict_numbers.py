"""Averages and verdicts, number by number: signs of orientations, frames of the camera, gains and angles."""

import math

import numpy as np
import pytest

from tendond.daemon.control.commissioning.averages import EMPTY, RESTLESS
from tendond.daemon.control.commissioning.verdict import Bounds, Motion, agrees, follows, judge, only_gain
from tendond.schemas.base import Vector3

BOUNDS = Bounds(angle=0.5, gain_min=0.6, gain_max=1.5, slack=0.001)
TIGHT = Bounds(angle=0.01, gain_min=0.6, gain_max=1.5, slack=0.001)
ALONG: Vector3 = (0.01, 0.0, 0.0)
EXPECTED: list[Vector3] = [
    (0.01, 0.003, 0.002),
    (-0.004, 0.009, 0.003),
    (-0.011, 0.002, -0.004),
    (0.001, -0.012, 0.005),
]


def turned(angle: float, gain: float = 1.0) -> Vector3:
    return (0.01 * gain * math.cos(angle), 0.01 * gain * math.sin(angle), 0.0)


@pytest.mark.parametrize("component", [0, 1, 2, 3])
def test_an_orientation_is_added_with_the_sign_that_is_nearer(component: int) -> None:
    other = [0.25] * 4
    other[component] = -0.9
    w, x, y, z = other
    first = EMPTY.add((1.0, 2.0, 3.0), (0.5, 0.5, 0.5, 0.5))
    assert first.orientation == (0.5, 0.5, 0.5, 0.5)
    assert first.add((0.0,) * 3, (w, x, y, z)).orientation == pytest.approx(tuple(0.5 - q for q in other))
    assert first.add((0.0,) * 3, (-w, -x, -y, -z)).orientation == pytest.approx(tuple(0.5 - q for q in other))


def test_opposite_orientations_that_cancel_are_no_rotation_and_a_position_alone_is_not_averaged() -> None:
    assert EMPTY.add((0.0,) * 3, (0.0, 0.0, 0.0, 0.0)).mean_orientation == (1.0, 0.0, 0.0, 0.0)
    assert RESTLESS.add((1.0, 2.0, 3.0), None, 10).now == EMPTY
    assert RESTLESS.add(None, None, 10).cycles == 1


def test_a_motion_is_wrong_in_size_only_where_its_direction_is_right_or_it_has_none() -> None:
    assert only_gain(Motion(turned(0.49, 3.0), ALONG), BOUNDS)
    assert not only_gain(Motion(turned(0.51, 3.0), ALONG), BOUNDS)
    assert not only_gain(Motion(turned(2.0, 0.26), ALONG), BOUNDS)
    assert only_gain(Motion(turned(2.0, 0.24), ALONG), BOUNDS)


def test_the_gain_is_that_of_the_growth_where_there_were_two_looks() -> None:
    motion = Motion((0.02, 0.0, 0.0), (0.015, 0.0, 0.0), first=((0.012, 0.0, 0.0), (0.011, 0.0, 0.0)))
    assert motion.gain == pytest.approx(2.0)
    assert motion.size == pytest.approx(4.0 / 3.0)
    assert Motion(ALONG, (0.0, 0.0, 0.0)).size == pytest.approx(0.01 / 1e-12)
    grown = Motion((0.02, 0.0, 0.0), ALONG, first=(ALONG, ALONG))
    assert grown.gain == pytest.approx(0.01 / 1e-12)
    assert Motion((0.0, 0.01, 0.0), ALONG).angle == pytest.approx(math.pi / 2)
    for gain, passes in ((0.6, True), (1.5, True), (0.0, False)):
        assert agrees(Motion((gain, 0.0, 0.0), (1.0, 0.0, 0.0)), BOUNDS) is passes
    assert not agrees(Motion((0.0, 0.0, 0.0), ALONG), Bounds(angle=4.0, gain_min=0.0, gain_max=1.5, slack=0.001))


@pytest.mark.parametrize(
    ("commanded", "reported", "expected"),
    [
        (0.004, None, True), (0.004, 0.00699, True), (0.004, 0.00701, False), (0.004, 0.00101, True),
        (0.004, 0.00099, False), (-0.004, -0.00699, True), (-0.004, -0.00701, False), (0.0, 0.00099, True),
        (0.0, 0.00101, False),
    ],
)  # fmt: skip
def test_a_servo_follows_that_reports_half_of_the_displacement_but_for_a_millimetre(
    commanded: float, reported: float | None, expected: bool
) -> None:
    assert follows(Motion(ALONG, ALONG, commanded, reported), BOUNDS) is expected


FRAMES = {
    "mirrored in x": ((-1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "mirrored in y": ((1, 0, 0), (0, -1, 0), (0, 0, 1)),
    "rotated by 180 degrees about z": ((-1, 0, 0), (0, -1, 0), (0, 0, 1)),
    "rotated by 90 degrees about z": ((0, -1, 0), (1, 0, 0), (0, 0, 1)),
    "rotated by -90 degrees about z": ((0, 1, 0), (-1, 0, 0), (0, 0, 1)),
    "one with x and y swapped": ((0, 1, 0), (1, 0, 0), (0, 0, 1)),
}


def seen(matrix: object, expected: list[Vector3] = EXPECTED) -> list[Motion]:
    moved = [np.array(matrix, dtype=float) @ np.array(one) for one in expected]
    return [Motion((x, y, z), one) for (x, y, z), one in zip(moved, expected, strict=True)]


@pytest.mark.parametrize("name", FRAMES)
def test_a_frame_of_the_camera_is_named_that_explains_every_motion_and_only_that(name: str) -> None:
    found = judge(seen(FRAMES[name]), TIGHT)
    assert found.endswith(f"; or is the camera's frame {name}?")
    assert found.count("camera") == 1
    spoilt = seen(FRAMES[name])
    spoilt[2] = Motion(spoilt[2].expected, spoilt[2].expected)
    assert "camera" not in judge(spoilt, TIGHT)


def test_no_frame_is_blamed_where_a_tendon_does_not_move_the_tip() -> None:
    square = [turned(k * math.pi / 2.0) for k in range(4)]
    motions = seen(FRAMES["mirrored in x"], square)
    assert "camera" in judge(motions, BOUNDS)
    x, y, z = motions[1].measured
    motions[1] = Motion((0.24 * x, 0.24 * y, 0.24 * z), motions[1].expected)
    found = judge(motions, BOUNDS)
    assert "camera" not in found
    assert "tendon 1 does not move the tip (2.4 of 10.0 mm)" in found


SQUARE = [turned(k * math.pi / 2.0) for k in range(4)]
DEAD: Vector3 = (0.0, 0.0, 0.0)


def verdict(**measured: Vector3) -> str:
    return judge([Motion(measured.get(f"t{k}", one), one) for k, one in enumerate(SQUARE)], BOUNDS)


def test_two_tendons_are_swapped_where_one_moves_as_the_other_and_that_one_likewise_or_not_at_all() -> None:
    assert "are tendons 0 and 1 swapped?" in verdict(t0=SQUARE[1], t1=SQUARE[0])
    assert "are tendons 0 and 1 swapped?" in verdict(t0=SQUARE[1], t1=DEAD)
    assert "are tendons 0 and 1 swapped?" in verdict(t0=DEAD, t1=SQUARE[0])
    assert "swapped" not in verdict(t0=SQUARE[1], t1=SQUARE[2])
    assert "swapped" not in verdict(t0=SQUARE[1])
    assert "swapped" not in verdict(t0=DEAD, t1=DEAD)
    both = verdict(t0=SQUARE[1], t1=SQUARE[0], t2=SQUARE[3], t3=SQUARE[2])
    assert "are tendons 0 and 1 swapped?; are tendons 2 and 3 swapped?" in both


def test_another_order_is_named_where_every_wrong_tendon_moves_as_another() -> None:
    words = "are the tendons connected in another order?"
    assert words in verdict(t0=SQUARE[1], t1=SQUARE[2], t2=SQUARE[0])
    assert words not in verdict(t0=SQUARE[1])
    assert words not in verdict(t0=SQUARE[1], t1=SQUARE[2], t2=turned(math.radians(215.0)))
    assert words not in verdict(t0=SQUARE[1], t1=SQUARE[0])


def test_the_power_is_asked_about_where_no_tendon_moves_the_tip() -> None:
    words = "is the power of the servos on, and the arm free?"
    weak = [(0.24 * x, 0.24 * y, z) for x, y, z in SQUARE]
    assert words in verdict(**{f"t{k}": one for k, one in enumerate(weak)})
    assert words not in verdict(t0=DEAD, t1=DEAD, t2=DEAD)
    x, y, z = SQUARE[3]
    strong = [*weak[:3], (0.26 * x, 0.26 * y, 0.26 * z)]
    assert words not in verdict(**{f"t{k}": one for k, one in enumerate(strong)})


def test_a_tendon_moves_as_the_nearest_other_within_the_angle_that_passes() -> None:
    assert verdict(t0=turned(math.pi / 2.0 - 0.49)).startswith("tendon 0 moves the tip as tendon 1 should")
    assert verdict(t0=turned(math.pi / 2.0 - 0.51)).startswith("tendon 0 moves the tip 61 degrees off its direction")
    assert verdict(t0=turned(0.51)).startswith("tendon 0 moves the tip 29 degrees off its direction")
    assert verdict(t0=turned(math.pi / 2.0 + 0.49)).startswith("tendon 0 moves the tip as tendon 1 should")
    near = [ALONG, turned(0.1), *SQUARE[1:3]]
    motions = [Motion((0.02, 0.0, 0.0), near[0]), *(Motion(one, one) for one in near[1:])]
    assert judge(motions, BOUNDS).startswith("tendon 0 moves the tip 2.0 times as far")  # its own direction is nearer


def test_a_small_angle_off_is_said_as_a_size_and_a_list_ends_after_three() -> None:
    radius = "times as far as it should: is its spool's radius, or the rod's stiffness, right?"
    assert verdict(t0=turned(math.radians(19.0), 1.9)).startswith(f"tendon 0 moves the tip 1.9 {radius}")
    assert verdict(t0=turned(math.radians(21.0), 1.9)).startswith("tendon 0 moves the tip 21 degrees off")
    big = {f"t{k}": (1.9 * x, 1.9 * y, z) for k, (x, y, z) in enumerate(SQUARE)}
    assert verdict(**big).endswith(f"tendon 2 moves the tip 1.9 {radius}; and 1 more tendons")
    assert verdict(**{k: big[k] for k in ("t0", "t1", "t2")}).endswith(radius)


@pytest.mark.parametrize(("reported", "words"), [(0.0001, "reports 0.1 mm where 4.0 mm"), (0.004, "does not move")])
def test_a_dead_tendon_is_the_servos_fault_where_it_reports_no_displacement(reported: float, words: str) -> None:
    motions = [Motion(one, one, 0.004, 0.004) for one in SQUARE]
    motions[2] = Motion(DEAD, SQUARE[2], 0.004, reported)
    assert words in judge(motions, BOUNDS)
    moving = [*motions[:2], Motion((-0.02, 0.0, 0.0), SQUARE[2], 0.004, 0.0001), motions[3]]
    assert "2.0 times as far" in judge(moving, BOUNDS)


def test_a_motion_broken_off_is_named_by_the_motions_before_it_and_the_arms_after_it() -> None:
    arms = [np.array(one) for one in SQUARE]
    before = Motion(SQUARE[2], SQUARE[2])  # not where its arm is
    far = Motion((-0.03, 0.0, 0.0), SQUARE[1])
    assert judge([before, far], BOUNDS, arms, finished=False).startswith("tendon 1 moves the tip as tendon 0 should")
    up = Motion((0.0, -0.03, 0.0), SQUARE[1])
    assert judge([before, up], BOUNDS, arms, finished=False).startswith("tendon 1 moves the tip as tendon 3 should")
    assert judge([Motion(DEAD, SQUARE[0]), Motion((0.0, 0.03, 0.0), SQUARE[1])], BOUNDS, arms, finished=False) == ""
