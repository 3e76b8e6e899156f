"""Tensions for a change of pose: the pose first, then the preferred tensions, within bounds."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from tendond.daemon.control.pose.allocation import allocate, bounded


@pytest.mark.parametrize("seed", range(20))
def test_the_bounded_problem_is_solved_as_scipy_solves_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 10))
    a, b = rng.normal(size=(n + 3, n)), 3.0 * rng.normal(size=n + 3)
    low, high = -rng.uniform(0.0, 1.0, n), rng.uniform(0.0, 1.0, n)
    expected = lsq_linear(a, b, (low - 1e-12, high + 1e-12), method="bvls", tol=1e-14).x
    assert np.allclose(bounded(a, b, np.eye(n), low, high), expected, atol=1e-7)


@pytest.mark.parametrize("seed", range(10))
def test_the_pose_is_reached_with_tensions_next_to_the_preferred(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    jacobian, tension = rng.normal(size=(4, 9)), rng.uniform(1.0, 5.0, 9)
    preferred, low, high = np.ones(9), 1.0 - tension, 20.0 - tension
    reachable = jacobian @ (rng.uniform(1.0, 6.0, 9) - tension)
    change = allocate(jacobian, reachable, tension, preferred, low, high)
    assert np.abs(jacobian @ change - reachable).max() < 1e-4 * np.abs(reachable).max()
    assert np.all(tension + change >= 1.0 - 1e-9)
    stacked = np.vstack((1e5 * jacobian, np.eye(9)))
    wanted = np.concatenate((1e5 * reachable, preferred - tension))
    other = lsq_linear(stacked, wanted, (low - 1e-12, high + 1e-12), method="bvls", tol=1e-14).x
    assert np.sum((tension + change - preferred) ** 2) < np.sum((tension + other - preferred) ** 2) * 1.001 + 1e-6


def test_what_cannot_be_reached_is_approached_and_no_bound_is_passed() -> None:
    rng = np.random.default_rng(7)
    jacobian, tension = rng.normal(size=(6, 6)), np.full(6, 1.0)
    low, high = np.zeros(6), np.full(6, 0.5)
    change = allocate(jacobian, 100.0 * rng.normal(size=6), tension, np.ones(6), low, high)
    assert np.all(change >= low)
    assert np.all(change <= high)
    assert change.max() > 0.0


def test_without_any_effect_on_the_pose_the_tensions_tend_to_the_preferred() -> None:
    change = allocate(np.zeros((3, 4)), np.ones(3), np.full(4, 5.0), np.ones(4), np.full(4, -2.0), np.zeros(4))
    assert np.allclose(change, -2.0)
