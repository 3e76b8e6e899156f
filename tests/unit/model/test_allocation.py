"""Tensions for a bending moment: scipy and the optimality conditions say that they are minimal, and continuous."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from tendond.model.errors import ParameterError
from tendond.model.tendons.allocation import EDGE, Allocation

Array = NDArray[np.float64]

FOUR = ((0.02, 0.0), (0.0, 0.02), (-0.02, 0.0), (0.0, -0.02))


@st.composite
def tendons(draw: st.DrawFn) -> Allocation:
    """3 to 16 tendons at any angles and distances that surround the rod, with any bounds."""
    count = draw(st.integers(3, 16))
    angles = draw(st.lists(st.floats(0.0, 2.0 * math.pi), min_size=count, max_size=count))
    sizes = draw(st.lists(st.floats(0.002, 0.05), min_size=count, max_size=count))
    tension_min = draw(st.floats(0.0, 5.0))
    places = [(r * math.cos(a), r * math.sin(a)) for r, a in zip(sizes, angles, strict=True)]
    ordered = np.sort(angles)
    assume(np.max(np.diff(np.append(ordered, ordered[0] + 2.0 * math.pi))) < math.pi - 0.05)
    return Allocation(places, tension_min, tension_min + draw(st.floats(1.0, 100.0)))


directions = st.floats(0.0, 2.0 * math.pi)
parts = st.floats(0.0, 2.0)


def moment_at(one: Allocation, direction: float, part: float) -> Array:
    """A moment in a direction from the middle of the feasible ones; from 1 on it may be infeasible."""
    middle = one.corners.mean(axis=0)
    reach = np.max(np.hypot(*(one.corners - middle).T))
    return np.asarray(middle + part * reach * np.array([math.cos(direction), math.sin(direction)]))


def scale(one: Allocation) -> float:
    """Size of the moments [N m]."""
    return float(np.abs(one.corners).max())


@settings(deadline=None)
@given(tendons(), directions, parts)
def test_the_moment_is_met_or_the_nearest_that_can_be_had_within_the_bounds(
    one: Allocation, direction: float, part: float
) -> None:
    """The nearest one is scipy's, of a bounded least-squares problem, but for the little that keeps off the edge."""
    wanted = moment_at(one, direction, part)
    found = one.tensions(wanted)
    assert found.min() >= one.tension_min
    assert found.max() <= one.tension_max
    other = lsq_linear(one.arms / 0.02, wanted / 0.02, (one.tension_min, one.tension_max), method="bvls", tol=1e-14).x
    missed, theirs = (float(np.linalg.norm(one.moment(each) - wanted)) for each in (found, other))
    assert missed <= theirs + 3.0 * EDGE * scale(one)


@settings(deadline=None)
@given(tendons(), directions, st.floats(0.0, 0.99))
def test_the_tensions_are_minimal(one: Allocation, direction: float, part: float) -> None:
    """Karush, Kuhn and Tucker: T - tension_min = r . y between the bounds, beyond them at the bounds."""
    middle, edge = one.corners.mean(axis=0), one.corners[0] + direction / 7.0 * (one.corners[1] - one.corners[0])
    inside = middle + part * (edge - middle)
    found = one.tensions(inside)
    assert one.moment(found) == pytest.approx(inside, abs=1e-10 * scale(one))
    free = (found > one.tension_min + 1e-7) & (found < one.tension_max - 1e-7)
    y, *_ = np.linalg.lstsq(one.arms[:, free].T, found[free] - one.tension_min, rcond=None)
    pulled = one.arms.T @ y
    assume(free.sum() >= 2 and np.linalg.matrix_rank(one.arms[:, free], tol=1e-4) == 2)
    size = one.tension_max - one.tension_min
    assert pulled[free] == pytest.approx(found[free] - one.tension_min, abs=1e-6 * size)
    assert np.all(pulled[found <= one.tension_min + 1e-7] <= 1e-5 * size)
    assert np.all(pulled[found >= one.tension_max - 1e-7] >= size * (1.0 - 1e-5))


@settings(deadline=None)
@given(tendons(), directions, parts, directions)
def test_a_small_change_of_the_moment_is_a_small_change_of_the_tensions(
    one: Allocation, direction: float, part: float, step: float
) -> None:
    """Continuity holds where a tendon takes over, and at the edge of the feasible moments, too."""
    wanted = moment_at(one, direction, part)
    small = 1e-6 * scale(one)
    near = one.tensions(wanted + small * np.array([math.cos(step), math.sin(step)]))
    # The tendons' worst pair: two that are nearly parallel must change more than the moment does.
    places = one.arms.T
    worst = min(
        (np.linalg.svd(places[[i, j]], compute_uv=False)[-1] for i in range(len(places)) for j in range(i)),
        key=lambda value: value if value > 1e-9 else math.inf,
    )
    bound = 10.0 * math.sqrt(len(places)) * small / max(float(worst), 1e-9)
    assert np.max(np.abs(near - one.tensions(wanted))) <= bound + 1e-6


def test_four_tendons_share_as_one_would_by_hand() -> None:
    one = Allocation(FOUR, 1.0, 60.0)
    assert one.tensions(np.array([0.1, -0.04])) == pytest.approx([6.0, 1.0, 1.0, 3.0])
    assert one.tensions(np.zeros(2)) == pytest.approx([1.0] * 4)
    assert one.tensions(np.array([9.0, 0.0])) == pytest.approx([60.0, 1.0, 1.0, 1.0], rel=10.0 * EDGE)


def test_three_tendons_at_a_third_of_a_turn_reach_every_side() -> None:
    places = [(0.02 * math.cos(a), 0.02 * math.sin(a)) for a in (0.0, 2.0 * math.pi / 3.0, 4.0 * math.pi / 3.0)]
    one = Allocation(places, 0.5, 40.0)
    for angle in np.linspace(0.0, 2.0 * math.pi, 25):
        wanted = 0.3 * np.array([math.cos(angle), math.sin(angle)])
        found = one.tensions(wanted)
        assert one.moment(found) == pytest.approx(wanted, abs=1e-12)
        assert found.min() == pytest.approx(0.5)


def test_tendons_on_one_side_are_refused() -> None:
    for places in (FOUR[:2], FOUR[:3:2], [(0.02, 0.0), (0.0, 0.02), (-0.02, 0.0)]):
        with pytest.raises(ParameterError, match="do not surround the rod"):
            Allocation(places, 0.0, 60.0)
    with pytest.raises(ParameterError, match="tension_min = 60"):
        Allocation(FOUR, 60.0, 60.0)
