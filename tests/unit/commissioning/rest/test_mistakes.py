"""Mistakes of wiring and frames: each is named in whole, and what nothing explains is a distance."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.daemon.control.commissioning.averages import RESTLESS, RestWatch
from tendond.daemon.control.commissioning.mistakes import _frames, likely_mistakes
from tendond.daemon.control.commissioning.rest_check import rest_objection
from tendond.daemon.control.commissioning.rotations import rotation_matrix, turn_by
from tests.unit.commissioning.rest.rests import FAMILY, as_quaternion, degrees, family, rest

Array = NDArray[np.float64]


def test_all_frames_of_signed_axes_are_known_by_name_the_simple_ones_first() -> None:
    frames = _frames()
    names = [one.name for one in frames]
    assert len(set(names)) == len(names) == 47
    assert [len(name) for name in names] == sorted(map(len, names))
    by_name = {one.name: one.matrix for one in frames}
    for name, matrix in {
        "with x mirrored": np.diag([-1.0, 1.0, 1.0]),
        "with y mirrored": np.diag([1.0, -1.0, 1.0]),
        "with z mirrored": np.diag([1.0, 1.0, -1.0]),
        "with all axes mirrored": -np.eye(3),
        "with x and y swapped": np.eye(3)[[1, 0, 2]],
        "with x and z swapped": np.eye(3)[[2, 1, 0]],
        "with y and z swapped": np.eye(3)[[0, 2, 1]],
    }.items():
        assert by_name[name].tolist() == matrix.tolist()
    for axis, letter in enumerate("xyz"):
        for angle in (90, -90, 180):
            turn = turn_by(math.radians(angle) * np.eye(3)[axis])
            assert by_name[f"rotated by {angle} degrees about {letter}"] == pytest.approx(turn, abs=1e-12)
    for name, matrix in by_name.items():
        if name.startswith("with axes (x, y, z) that are the model's ("):
            axes = name[name.index("'s (") + 4 : -1].split(", ")
            assert set(axes) <= {"x", "y", "z", "-x", "-y", "-z"}
            rows = [(-1.0 if one[0] == "-" else 1.0) * np.eye(3)["xyz".index(one[-1])] for one in axes]
            assert matrix == pytest.approx(np.array(rows))
    assert sum("that are the model's" in name for name in names) == 47 - 7 - 9


POSITION, ROTATION = rest()
QUARTER = turn_by(degrees(z=90))


def named(position: Array, rotation: Array) -> list[str]:
    return likely_mistakes(FAMILY, position, as_quaternion(rotation))


@pytest.mark.parametrize(
    ("position", "rotation", "words"),
    [
        (1e3 * POSITION, ROTATION, "measured = model in mm"),
        (1e2 * POSITION, ROTATION, "measured = model in cm"),
        (1e-3 * POSITION, ROTATION, "measured = model in km: is it divided by 1000 twice?"),
        (POSITION / 0.0254, ROTATION, "measured = model in inches"),
        (0.8 * POSITION, ROTATION, "lengths are 0.8 of the model's: is rod.length right?"),
        (POSITION + np.array([0.03, 0.0, 0.0]), ROTATION, "base +30 mm along x off"),
        (POSITION + np.array([0.0, -0.03, 0.0]), ROTATION, "base -30 mm along y off"),
        (POSITION + np.array([0.02, 0.03, -0.03]), ROTATION, "base (+20, +30, -30) mm off"),
        (QUARTER @ POSITION, QUARTER @ ROTATION, "measured = model rotated by 90 degrees about z"),
        (turn_by(degrees(x=40)) @ POSITION, turn_by(degrees(x=40)) @ ROTATION,
         "rotated by 40 degrees about x: is the base's frame turned?"),
        (POSITION, turn_by(degrees(x=25)) @ ROTATION,
         "only its orientation is off, rotated by 25 degrees about x: do the markers' axes lie along the tip's?"),
        (POSITION, turn_by(degrees(z=-40)) @ ROTATION,
         "only its orientation is off, rotated by -40 degrees about z: do the markers' axes lie along the tip's?"),
        (turn_by(degrees(x=-15)) @ POSITION, turn_by(degrees(x=-15)) @ ROTATION,
         "rotated by -15 degrees about x: is the base's frame turned?"),
        (np.array([0.0, 0.0, 0.5]), np.eye(3),
         "the arm is straight: is it held, or does rod.gravity point another way?"),
    ],
)  # fmt: skip
def test_a_mistake_is_named_in_whole(position: Array, rotation: Array, words: str) -> None:
    assert words in named(position, rotation)
    assert 1 <= len(named(position, rotation)) <= 2


def test_an_inverted_orientation_and_another_order_are_named() -> None:
    turned = turn_by(degrees(y=-25)) @ turn_by(degrees(z=0))
    fit = FAMILY.fit(POSITION, ROTATION)
    assert fit.is_tolerated
    assert "measured = model with its orientation inverted (base seen from the tip)" in named(POSITION, ROTATION.T)
    rolled = rotation_matrix(np.roll(as_quaternion(ROTATION), -1))
    assert "measured = model with its quaternion in the order x y z w" in named(POSITION, rolled)
    assert named(POSITION, turned @ ROTATION)


def test_what_nothing_explains_is_said_as_a_distance() -> None:
    (at_base,) = named(np.array([0.009, 0.0, 0.0]), turn_by(degrees(z=77)))
    assert at_base == "the tip is at the base: are the units right, or is it the base's own pose?"
    assert "at the base" not in named(np.array([0.011, 0.0, 0.0]), turn_by(degrees(z=77)))[0]
    (far,) = named(np.array([0.2, 0.1, 0.3]), turn_by(degrees(x=100, y=40)))
    assert far.startswith("nothing simple: tip (")
    assert far.endswith(
        "mm from the nearest rest; is it another robot's pose, is the arm held, or a tendon still pulled?"
    )


def test_a_straight_arm_is_one_within_two_hundredths_of_its_length_and_the_tilt_that_is_tolerated() -> None:
    straight = np.array([0.0, 0.0, 0.5])
    words = ["the arm is straight: is it held, or does rod.gravity point another way?"]
    assert named(straight + np.array([0.0, 0.0099, 0.0]), np.eye(3)) == words
    assert named(straight + np.array([0.0, 0.0101, 0.0]), np.eye(3)) != words
    tilt = FAMILY.tolerances.tilt
    assert named(straight, turn_by(np.array([0.0, 0.99 * tilt, 0.0]))) == words
    assert named(straight, turn_by(np.array([0.0, 1.01 * tilt, 0.0]))) != words
    may = family((0.0, 0.0, 0.5), (0.2, 0.0, 0.4))
    assert likely_mistakes(may, straight, (1.0, 0.0, 0.0, 0.0)) != words  # where it may rest so


def watched(position: Array, rotation: Array, count: int = 10) -> RestWatch:
    watch, (x, y, z) = RESTLESS, position.tolist()
    for _ in range(count):
        watch = watch.add((x, y, z), as_quaternion(rotation), 25)
    return watch


def test_an_objection_tells_place_distance_angle_and_mistakes() -> None:
    assert rest_objection(FAMILY, RESTLESS) == "the tip has not been seen at rest yet: ask again in a moment"
    assert rest_objection(FAMILY, watched(POSITION, ROTATION)) == ""
    tip = POSITION + np.array([0.0, 0.03, 0.0])
    x, y, z = tip * 1e3
    said = rest_objection(FAMILY, watched(tip, ROTATION))
    assert said.startswith(
        f"the arm does not rest as the model does: tip at ({x:.0f}, {y:.0f}, {z:.0f}) mm, 30 mm and 0 degrees from "
        "the nearest rest; "
    )
    assert "; or: " in said or "base +30 mm along y off" in said
    turned = rest_objection(FAMILY, watched(POSITION, turn_by(degrees(z=40)) @ ROTATION))
    assert "mm, 0 mm and 40 degrees from the nearest rest; " in turned
    moving = watched(POSITION, ROTATION, 25).add((0.3, 0.0, 0.3), as_quaternion(ROTATION), 25)
    moved = moving.moved(FAMILY.length) * 1e3
    spot = replace(moving.now, count=5, position=(1.5, 0.0, 1.5))
    fresh = RestWatch(moving.cycles, spot, moving.before)
    assert moved > 0.0
    assert rest_objection(FAMILY, fresh) == (
        f"the tip is moving (by {moved:.0f} mm in a quarter of a second): wait until it rests"
    )
