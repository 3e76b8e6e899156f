"""The fit of a measured rest, number by number: rotations, misfits in closed form."""

import math

import numpy as np
import pytest

from tendond.daemon.control.commissioning.rests import Fit, Tolerances
from tendond.daemon.control.commissioning.rotations import rotation_matrix, rotation_vectors, turn_by
from tests.unit.commissioning.rest.rests import LENGTH, MARKERS, OFFSET, TILT, family

NONE = np.zeros(3)
UP = np.array([0.0, 0.0, LENGTH])


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_quarter_turn_takes_each_axis_to_the_next(axis: int) -> None:
    turn = turn_by(0.5 * math.pi * np.eye(3)[axis])
    first, second = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
    assert turn @ np.eye(3)[axis] == pytest.approx(np.eye(3)[axis])
    assert turn @ first == pytest.approx(second)
    assert turn @ second == pytest.approx(-first)
    q = [math.sqrt(0.5), 0.0, 0.0, 0.0]
    q[axis + 1] = math.sqrt(0.5)
    assert rotation_matrix(tuple(3.0 * x for x in q)) == pytest.approx(turn)  # of any size


def test_a_turn_about_any_axis_is_rodrigues_formula_and_comes_back_as_its_vector() -> None:
    random = np.random.default_rng(1)
    for angle in (1e-9, 1e-4, 0.7, 2.0, 3.1, math.pi):
        axis = random.normal(size=3)
        axis /= np.linalg.norm(axis)
        x, y, z = axis
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        matrix = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
        assert turn_by(angle * axis) == pytest.approx(matrix)
        back = rotation_vectors(np.stack([matrix, np.eye(3)]))
        sign = math.copysign(1.0, float(back[0] @ axis)) if angle == math.pi else 1.0
        assert back[0] == pytest.approx(sign * angle * axis, abs=1e-7)
        assert back[1] == pytest.approx(NONE)
    assert turn_by(NONE) == pytest.approx(np.eye(3))
    for axis in np.eye(3):
        assert np.abs(rotation_vectors(turn_by(math.pi * axis))) == pytest.approx(math.pi * axis)


def test_a_rest_may_fit_within_twice_what_is_tolerated() -> None:
    limit = 2.0 * math.sqrt(2.0) * (TILT * LENGTH + OFFSET)
    two = family((0.0, 0.0, LENGTH), (1.0, 0.0, 0.0))
    for position in (UP, np.array([1.0, 0.0, 0.0])):
        assert two.may_fit(position + np.array([0.0, 0.999 * limit, 0.0]))
        assert not two.may_fit(position + np.array([0.0, 1.001 * limit, 0.0]))


def test_the_misfit_is_that_of_the_likeliest_tilt_markers_and_offset() -> None:
    """Offset only along the rod; a turn of base or markers about it; across it all three: in closed form."""
    one = family()
    exact = one.fit(UP, np.eye(3))
    assert exact.misfit == pytest.approx(0.0)
    assert exact.is_tolerated
    along = one.fit(UP + np.array([0.0, 0.0, 0.006]), np.eye(3))
    assert along.misfit == pytest.approx((0.006 / OFFSET) ** 2)
    assert along.offset == pytest.approx([0.0, 0.0, 0.006])
    assert along.tilt == pytest.approx(NONE)
    assert not along.is_tolerated
    turned = one.fit(UP, turn_by(np.array([0.0, 0.0, 0.1])))
    assert turned.misfit == pytest.approx(0.1**2 / (TILT**2 + MARKERS**2))
    assert turned.tilt == pytest.approx([0.0, 0.0, 0.1 * TILT**2 / (TILT**2 + MARKERS**2)])
    assert turned.offset == pytest.approx(NONE)
    stiff = TILT**-2 + MARKERS**-2
    across = one.fit(UP + np.array([0.01, 0.0, 0.0]), np.eye(3))
    assert across.misfit == pytest.approx(0.01**2 / (OFFSET**2 + LENGTH**2 / stiff))
    tilt = 0.01 * LENGTH / OFFSET**2 / (stiff + LENGTH**2 / OFFSET**2)
    assert across.tilt == pytest.approx([0.0, tilt, 0.0])
    assert across.offset == pytest.approx([0.01 - tilt * LENGTH, 0.0, 0.0])
    sideways = one.fit(UP + np.array([0.0, 0.01, 0.0]), np.eye(3))
    assert sideways.tilt == pytest.approx([-tilt, 0.0, 0.0])


def test_other_tolerances_take_the_place_of_the_familys_own_and_two_is_tolerated() -> None:
    one = family()
    position = UP + np.array([0.0, 0.0, 0.006])
    assert one.fit(position, np.eye(3), Tolerances(TILT, 0.012, MARKERS)).misfit == pytest.approx(0.25)
    for misfit, borne in ((2.0, True), (2.0001, False)):
        assert Fit(misfit, 0.0, 1.0, UP, NONE, NONE).is_tolerated is borne


def test_the_nearest_rest_comes_with_its_weight_and_stiffness() -> None:
    many = family((0.0, 0.0, 0.5), (0.1, 0.0, 0.45), (0.2, 0.0, 0.4))
    for index in range(3):
        fit = many.fit(many.positions[index] + np.array([0.0, 0.001, 0.0]), np.eye(3))
        assert (fit.weight, fit.stiffness) == (0.01 * index, 1.0 + index)
        assert fit.position == pytest.approx(many.positions[index])
