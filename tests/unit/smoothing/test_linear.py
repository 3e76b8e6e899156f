"""The smoother of a linear model against the joint Gaussian distribution of all errors and measurements."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.stats import multivariate_normal

from tendond.model.estimation.kalman.memory import Reading, Taken
from tendond.offline.smoothing.linear import Line, Problem, likeliest_jump, smooth
from tendond.offline.smoothing.passes import run_forward
from tendond.offline.smoothing.path import PathModel
from tendond.offline.smoothing.stretches import Instant, Stretch
from tests.unit.smoothing.drawn import drawn, estimator_of

Array = NDArray[np.float64]


class Joint(NamedTuple):
    """All errors, one instant after the other, and all measurements of them."""

    mean: Array
    covariance: Array
    rows: Array
    lack: Array
    variance: Array


def joint_of(problem: Problem) -> Joint:
    """Roll the model out."""
    n, count = len(problem.mean), len(problem.taken)
    mean, covariance = [problem.mean], np.zeros((n * count, n * count))
    covariance[:n, :n] = problem.covariance
    for k, line in enumerate(problem.lines):
        a = np.zeros((n, n))
        a[: len(line.top)] = line.top
        below = np.arange(len(line.top), n)
        a[below, below] = line.decay
        mean.append(a @ mean[-1] + line.shift)
        old, now, new = slice(0, n * (k + 1)), slice(n * k, n * (k + 1)), slice(n * (k + 1), n * (k + 2))
        covariance[new, old] = a @ covariance[now, old]
        covariance[old, new] = covariance[new, old].T
        noise = np.concatenate((np.zeros(len(line.top)), line.noise))
        covariance[new, new] = a @ covariance[now, now] @ a.T + np.diag(noise)
    rows = block_diag(*(np.concatenate([np.zeros((0, n)), *(one.rows for one in taken)]) for taken in problem.taken))
    every = [one for taken in problem.taken for one in taken]
    lack, variance = (np.concatenate([getattr(one, name) for one in every]) for name in ("lack", "variance"))
    return Joint(np.concatenate(mean), covariance, rows, lack, variance)


def conditioned(problem: Problem) -> tuple[Array, Array]:
    """Condition the joint Gaussian of all instants on all measurements: means (K, N), covariances (K, N, N)."""
    mean, covariance, rows, lack, variance = joint_of(problem)
    n, count = len(problem.mean), len(problem.taken)
    gain = np.linalg.solve(rows @ covariance @ rows.T + np.diag(variance), rows @ covariance).T
    after, left = mean + gain @ (lack - rows @ mean), covariance - gain @ rows @ covariance
    blocks = [left[k * n : (k + 1) * n, k * n : (k + 1) * n] for k in range(count)]
    return after.reshape(count, n), np.array(blocks)


def log_likelihood(problem: Problem) -> float:
    """Of all measurements."""
    mean, covariance, rows, lack, variance = joint_of(problem)
    return float(multivariate_normal(rows @ mean, rows @ covariance @ rows.T + np.diag(variance)).logpdf(lack))


def random_problem(rng: np.random.Generator) -> Problem:
    """Five errors, of which the last is zero as long as it has no noise; some instants without a measurement."""
    root = rng.normal(size=(5, 5))
    root[4] = 0.0
    lines = [
        Line(
            0.5 * rng.normal(size=(2, 5)),
            np.array([1.0, 0.9, 0.8]),
            0.1 * rng.normal(size=5),
            np.array([0.1, 0.2, 0.3 * (k > 6)]),
        )
        for k in range(11)
    ]
    taken = [
        [
            Taken(rng.normal(size=(2, 5)), rng.normal(size=2), np.array([0.01, 0.02]))
            for _ in range(int(rng.integers(0, 3)))
        ]
        for _ in range(12)
    ]
    return Problem(np.zeros(5), root @ root.T, lines, taken, (2,), slice(2, 4))


@pytest.mark.parametrize("seed", range(5))
def test_smoothed_errors_are_those_of_the_joint_gaussian(seed: int) -> None:
    problem = random_problem(np.random.default_rng(seed))
    mean, covariance = conditioned(problem)
    found = smooth(problem)
    np.testing.assert_allclose(found.mean, mean, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(found.covariance, covariance, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_the_likeliest_jump_is_that_of_the_likelihoods_with_a_jump_before_each_instant(seed: int) -> None:
    problem = random_problem(np.random.default_rng(seed))
    none, variance = log_likelihood(problem), 0.7
    gains = [log_likelihood(problem.with_jump(k, variance)) - none for k in range(len(problem.taken))]
    best, gain = likeliest_jump(smooth(problem), variance)
    assert best == int(np.argmax(gains))
    assert gain == pytest.approx(max(gains), rel=1e-6)


def test_the_rods_own_linear_model_is_smoothed_as_the_joint_gaussian() -> None:
    """Of a rod that rests, with measurements that move it little; in units of the standard deviations."""
    estimator, rng = estimator_of(), np.random.default_rng(1)
    one = drawn(estimator, np.zeros((25, 4)), rng)
    path = one.model.follow(np.tile(one.model.vector(one.model.rest, one.model.start), (25, 1)))
    problem = one.model.problem(path)
    mean, covariance = conditioned(problem)
    found = smooth(problem)
    spread = np.sqrt(np.maximum(np.einsum("kii->ki", covariance), 0.0))
    unknown = spread <= 1e-9 * spread.max(axis=0)
    assert unknown[0, estimator.errors.rate].all()  # at rest
    assert not unknown[1:, : estimator.errors.force.stop].any()
    spread[unknown] = 1e-9
    assert np.abs((found.mean - mean) / spread).max() < 1e-6
    off = (found.covariance - covariance) / (spread[:, :, None] * spread[:, None, :])
    off[unknown] = 0.0
    assert np.abs(off).max() < 1e-6


def test_at_the_end_the_smoother_knows_what_the_estimator_knows() -> None:
    """The one filters numbers and factors, in a memory of moments; the other covariances, about a path.

    Where all is as expected, the robot rests, and both have the same derivatives.
    """
    estimator = estimator_of()
    pulls = np.full((60, 4), 2.0)
    still = PathModel(estimator, Stretch(tuple(Instant(i, 0.0, pull, ()) for i, pull in enumerate(pulls)), pulls[0]))
    place, turn = estimator.rod.strain_rod.tip(still.rest.strain)
    seen = (Reading(0, 0.0, place, turn),)
    model = PathModel(
        estimator, Stretch(tuple(replace(one, readings=seen) for one in still.stretch.instants), pulls[0])
    )
    forward = run_forward(model)
    found = smooth(model.problem(model.follow(forward.errors)))
    spread = np.sqrt(np.diag(found.covariance[-1])[estimator.errors.force])
    np.testing.assert_allclose(spread, forward.force_deviation[-1], rtol=1e-5)
