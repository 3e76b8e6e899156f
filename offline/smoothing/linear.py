"""The fixed-interval smoother of a linear model with Gaussian errors: a Kalman filter, and adjoints back through it.

Sources: G. J. Bierman, "Fixed interval smoothing with discrete measurements", Int. J. Control 18, 1973, for the adjoint
form; its result is that of H. E. Rauch, F. Tung, C. T. Striebel, "Maximum likelihood estimates of linear dynamic
systems", AIAA J. 3, 1965. It inverts no covariance of the errors, so that errors may be zero: that of a slack tendon.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.estimation.kalman.factored import factors_of
from tendond.model.estimation.kalman.memory import Taken
from tendond.model.estimation.kalman.taking import believed

Array = NDArray[np.float64]

POSE = 0
"""Index of the tip's pose among the sensors."""


@dataclass(frozen=True)
class Line:
    """The model from one instant to the next, for N errors x: x' = A x + shift + noise.

    Attributes:
        top: first rows of A, shape (t, N). decay: diagonal of A below them, shape (N - t,).
        shift: shape (N,). noise: variances that the last N - t errors gain, shape (N - t,).
    """

    top: Array
    decay: Array
    shift: Array
    noise: Array

    def ahead(self, x: Array) -> Array:
        """Return A times a vector or matrix, shape (N, ...)."""
        below = x[len(self.top) :]
        return np.concatenate((self.top @ x, (self.decay * below.T).T))

    def back(self, x: Array) -> Array:
        """Return A' times a vector or matrix, shape (N, ...)."""
        t = len(self.top)
        found = self.top.T @ x[:t]
        found[t:] += (self.decay * x[t:].T).T
        return np.asarray(found)


@dataclass(frozen=True)
class Problem:
    """What is known of N errors at K instants.

    Attributes:
        mean: expected errors at the first instant, shape (N,). covariance: of them, shape (N, N).
        lines: model between them, K - 1. taken: measurements at each instant, K. groups: of each sensor, the numbers
            that are believed or refused together. jumping: errors that may change at once.
    """

    mean: Array
    covariance: Array
    lines: Sequence[Line]
    taken: Sequence[Sequence[Taken]]
    groups: Sequence[int]
    jumping: slice

    def with_jump(self, k: int, variance: float) -> "Problem":
        """Return the problem with a jump before the measurements of an instant, of this variance in each error."""
        jump = np.zeros(len(self.mean))
        jump[self.jumping] = variance
        if k == 0:
            return replace(self, covariance=self.covariance + np.diag(jump))
        lines, before = list(self.lines), self.lines[k - 1]
        lines[k - 1] = replace(before, noise=before.noise + jump[len(before.top) :])
        return replace(self, lines=lines)


class _Innovation(NamedTuple):
    """rows: shape (r, N); innovation: (r,); inverse: of its covariance; weighted: both multiplied; gain: (N, r)."""

    rows: Array
    innovation: Array
    inverse: Array
    weighted: Array
    gain: Array

    @property
    def kept(self) -> Array:
        """What is left of errors, shape (N, N)."""
        return np.eye(len(self.gain)) - self.gain @ self.rows


@dataclass(frozen=True)
class Smoothed:
    """Errors by all measurements.

    Attributes:
        mean: shape (K, N). covariance: shape (K, N, N).
        score: derivative of the log likelihood by a change of what may jump, before an instant, shape (K, j).
        information: its covariance, which is minus its own derivative, shape (K, j, j).
        square: sum of squares of the filter's innovations, in units of their expected spread. numbers: of them.
    """

    mean: Array
    covariance: Array
    score: Array
    information: Array
    square: float
    numbers: int


def smooth(problem: Problem) -> Smoothed:
    """Return what is known of the errors by the measurements before and after each instant."""
    n, count = len(problem.mean), len(problem.taken)
    means, covariances = np.empty((count, n)), np.empty((count, n, n))
    steps: list[_Innovation | None] = []
    mean, covariance, square, numbers = problem.mean, problem.covariance, 0.0, 0
    for k in range(count):
        if k:
            mean, covariance = _predict(problem.lines[k - 1], mean, covariance)
        step = _innovation(problem, k, mean, covariance)
        if step is not None:
            numbers += len(step.weighted)
            square += float(step.innovation @ step.weighted)
            mean = mean + covariance @ (step.rows.T @ step.weighted)
            covariance = step.kept @ covariance
            covariance = 0.5 * (covariance + covariance.T)
        means[k], covariances[k] = mean, covariance
        steps.append(step)
    score, information = _go_back(problem, steps, means, covariances)
    return Smoothed(means, covariances, score, information, square, numbers)


def likeliest_jump(found: Smoothed, variance: float) -> tuple[int, float]:
    """Return the instant before which a jump is likeliest, and the logarithm of its likelihood against none.

    The jump's size is unknown, of this variance in each error. Source: P. de Jong, J. Penzer, "Diagnosing shocks in
    time series", J. Am. Stat. Assoc. 93, 1998: the adjoint is the shock's score.
    """
    size = found.information.shape[-1]
    spread = found.information + np.eye(size) / variance
    gained = np.einsum("ki,ki->k", found.score, np.linalg.solve(spread, found.score[:, :, None])[:, :, 0])
    gains = 0.5 * (gained - np.linalg.slogdet(np.eye(size) + variance * found.information)[1])
    best = int(np.argmax(gains))
    return best, float(gains[best])


def _predict(line: Line, mean: Array, covariance: Array) -> tuple[Array, Array]:
    ahead = line.ahead(line.ahead(covariance).T)
    at = np.arange(len(line.top), len(mean))
    ahead[at, at] += line.noise
    return line.ahead(mean) + line.shift, ahead


def _innovation(problem: Problem, k: int, mean: Array, covariance: Array) -> _Innovation | None:
    """Return what the measurements of an instant say beyond what was expected; none where there are none."""
    kept = []
    for one in problem.taken[k]:
        if one.sensor != POSE:
            one, _ = believed(one, factors_of(covariance), mean, problem.groups[one.sensor])
        if len(one.lack):
            kept.append(one)
    if not kept:
        return None
    rows = np.concatenate([one.rows for one in kept])
    innovation = np.concatenate([one.lack for one in kept]) - rows @ mean
    variance = np.concatenate([one.variance for one in kept])
    across = rows @ covariance
    inverse = np.linalg.inv(across @ rows.T + np.diag(variance))
    inverse = 0.5 * (inverse + inverse.T)
    return _Innovation(rows, innovation, inverse, inverse @ innovation, across.T @ inverse)


def _go_back(
    problem: Problem, steps: Sequence[_Innovation | None], means: Array, covariances: Array
) -> tuple[Array, Array]:
    """Turn the filter's means and covariances, after the measurements of each instant, into smoothed ones, in place.

    Return the adjoint before the measurements of each instant, and its covariance among what may jump.
    """
    j = problem.jumping
    scores = np.empty_like(means[:, j])
    informations = np.empty((*scores.shape, scores.shape[1]))
    n = means.shape[1]
    pull, information = np.zeros(n), np.zeros((n, n))  # the adjoint, and its covariance
    for k in range(len(steps) - 1, -1, -1):
        covariance, step = covariances[k], steps[k]
        means[k] += covariance @ pull
        gained = covariance @ information @ covariance
        covariances[k] = covariance - 0.5 * (gained + gained.T)
        if step is not None:
            kept = step.kept
            pull = step.rows.T @ step.weighted + kept.T @ pull
            information = step.rows.T @ step.inverse @ step.rows + kept.T @ information @ kept
        scores[k], informations[k] = pull[j], information[j, j]
        if k:
            line = problem.lines[k - 1]
            pull = line.back(pull)
            information = line.back(line.back(information).T)
    return scores, informations
