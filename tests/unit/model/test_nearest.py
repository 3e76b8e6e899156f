"""The smallest change of a command, beside SciPy's bounded minimiser of the same function."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import Bounds, minimize

from tendond.model.numerics.nearest import WEIGHT, smallest_change


@pytest.mark.parametrize("seed", range(40))
def test_it_is_the_minimum_that_scipy_finds(seed: int) -> None:
    generator = np.random.default_rng(seed)
    n, count = int(generator.integers(1, 7)), int(generator.integers(1, 9))
    rows = generator.normal(size=(count, n))
    rows /= np.linalg.norm(rows, axis=1)[:, None]
    missing, low, high = generator.normal(size=count), -2.0 * generator.random(n), 2.0 * generator.random(n)

    def cost(x: NDArray[np.float64]) -> float:
        return float(0.5 * x @ x + 0.5 * WEIGHT * np.sum(np.maximum(missing - rows @ x, 0.0) ** 2))

    def slope(x: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(x - WEIGHT * rows.T @ np.maximum(missing - rows @ x, 0.0))

    other = minimize(
        cost,
        np.zeros(n),
        jac=slope,
        bounds=Bounds(low, high),
        method="L-BFGS-B",
        options={"maxiter": 5000, "ftol": 1e-16, "gtol": 1e-9},
    )
    found = smallest_change(rows, missing, low, high)
    assert (found >= low).all()
    assert (found <= high).all()
    assert cost(found) <= other.fun * (1.0 + 1e-4) + 1e-6


def test_what_is_met_already_changes_nothing() -> None:
    assert not smallest_change(np.eye(2), np.array([-1.0, 0.0]), np.full(2, -1.0), np.ones(2)).any()


def test_one_row_is_met_by_a_step_along_it() -> None:
    row = np.array([[0.6, 0.8]])
    np.testing.assert_allclose(
        smallest_change(row, np.array([0.5]), np.full(2, -9.0), np.full(2, 9.0)), [0.3, 0.4], atol=1e-5
    )


def test_what_cannot_change_leaves_the_rest_to_do_all() -> None:
    row = np.array([[0.6, 0.8]])
    found = smallest_change(row, np.array([0.5]), np.array([0.0, -9.0]), np.array([0.0, 9.0]))
    np.testing.assert_allclose(found, [0.0, 0.625], atol=1e-5)
