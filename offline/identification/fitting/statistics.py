"""Statistics of a fit: standard errors, correlations, and combinations that the data do not identify.

Residuals are not white noise: the model's error persists from sample to sample. The covariance is therefore the
sandwich (J'WJ)^-1 S (J'WJ)^-1, with S of the scores' autocovariances, consistent under heteroskedasticity and
autocorrelation (Newey & West, Econometrica 55, 1987), in Bartlett's window, and Andrews' bandwidth for it (Econometrica
59, 1991), which grows with the scores' correlation. The remaining error of the time step is not noise, but bounds how
well a value is known: it is added as one more standard deviation, along one direction.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.offline.identification.fitting.solve import FitResult

Array = NDArray[np.float64]

SINGULAR = 1e-6
"""Fraction of the largest singular value below which a direction is not identifiable: differences are no more exact."""

INVOLVED = 0.3
"""Component of a direction above which a parameter is named in it."""

ALIKE = 0.9
"""Correlation above which two parameters cannot be distinguished."""


@dataclass(frozen=True)
class Direction:
    """A combination of parameters that the data do not identify.

    Attributes:
        names: its parameters. deviation: standard error along it, in units of the max. error; may be infinite.
    """

    names: tuple[str, ...]
    deviation: float


@dataclass(frozen=True)
class Statistics:
    """Statistics of a fit's coordinates.

    Attributes:
        covariance: shape (p, p); infinite on the diagonal where a parameter is not identifiable.
        correlation: correlation of the noise in them, shape (p, p).
        inflation: standard error from noise over what it would be if that were white, by parameter, shape (p,).
        effective: equivalent samples of white noise, by the largest inflation. samples: actual samples.
        unidentifiable: directions that the data do not identify, the worst first.
    """

    covariance: Array
    correlation: Array
    inflation: Array
    effective: float
    samples: int
    unidentifiable: tuple[Direction, ...]

    @property
    def deviations(self) -> Array:
        """Standard errors, shape (p,)."""
        return np.sqrt(np.diag(self.covariance))


def statistics(fit: FitResult) -> Statistics:
    """Compute the statistics of a fit.

    A prior counts as a measurement of its own: its score has the variance that its sigma says.
    """
    if not fit.parameters:
        none = np.zeros((0, 0))
        return Statistics(none, none, np.zeros(0), 0.0, sum(len(blocks[0]) for blocks in fit.residuals), ())
    scores, start = [], 0
    bread = fit.jacobian.T @ (fit.weights[:, None] * fit.jacobian)
    white = np.zeros_like(bread)
    samples = 0
    for recording in fit.residuals:
        for block in recording:
            rows, width = block.shape
            part = slice(start, start + block.size)
            start += block.size
            jacobian = fit.jacobian[part].reshape(rows, width, -1)
            weighted = (fit.weights[part] * block.ravel()).reshape(rows, width)
            scores.append(np.einsum("kwp,kw->kp", jacobian, weighted))
            white += float(np.mean(weighted**2)) * np.einsum("kwp,kwq->pq", jacobian, jacobian)
            samples += rows
    names = [parameter.name for parameter in fit.parameters]
    max_deviation = np.array([parameter.max_deviation for parameter in fit.parameters])
    known = fit.prior_scale * fit.jacobian[start:]
    return covariance(bread, scores, white, names, max_deviation, samples, fit.remaining, known.T @ known)


def covariance(
    bread: Array,
    scores: Sequence[Array],
    white: Array,
    names: Sequence[str],
    max_deviation: Array,
    samples: int,
    remaining: Array | None = None,
    priors: Array | None = None,
) -> Statistics:
    """Compute the sandwich covariance, and the directions that the data do not identify.

    Args:
        bread: J'WJ, shape (p, p).
        scores: scores of each stretch of data, a row for each instant, in order of time, shape (k, p).
        white: J'W^2 J with the residuals' variance, as if they were white, shape (p, p).
        names: names of the parameters.
        max_deviation: deviation of each parameter above which it is not identifiable.
        samples: number of instants.
        remaining: deviation of each coordinate that noise does not explain, shape (p,); none: zeros.
        priors: variance of the priors' scores, shape (p, p); none: there are none.
    """
    rows = sum(len(part) for part in scores)
    filling = long_run(scores) * rows / max(rows - len(names) / 3.0, 1.0)  # three coordinates a row
    if priors is not None:
        filling, white = filling + priors, white + priors
    scaled = bread * np.outer(max_deviation, max_deviation)
    size = np.sqrt(np.maximum(np.diag(scaled), 1e-300))
    values, vectors = np.linalg.eigh(scaled / np.outer(size, size))
    observable = values > SINGULAR**2 * values[-1]
    observable &= values > 0.0
    inverse = (vectors[:, observable] / values[observable]) @ vectors[:, observable].T / np.outer(size, size)
    z = inverse @ (filling * np.outer(max_deviation, max_deviation)) @ inverse
    z_white = inverse @ (white * np.outer(max_deviation, max_deviation)) @ inverse
    z = 0.5 * (z + z.T)
    noise = np.sqrt(np.maximum(np.diag(z), 0.0))
    safe = np.where(noise > 0.0, noise, 1.0)
    correlation = np.clip(z / np.outer(safe, safe), -1.0, 1.0)
    np.fill_diagonal(correlation, 1.0)
    if remaining is not None:
        z += np.outer(remaining / max_deviation, remaining / max_deviation)
    unobservable = [vectors[:, k] / size for k in np.flatnonzero(~observable)]
    directions = []
    lost = np.zeros(len(names), dtype=bool)
    for vector in unobservable:
        vector = vector / np.linalg.norm(vector)
        lost |= np.abs(vector) > 0.01
        directions.append(Direction(_involved(vector, names), math.inf))
    spread, axes = np.linalg.eigh(z)
    for k in np.argsort(spread)[::-1]:
        if spread[k] > 1.0:
            directions.append(Direction(_involved(axes[:, k], names), math.sqrt(spread[k])))
    found = z * np.outer(max_deviation, max_deviation)
    found[lost, lost] = np.inf
    white_deviation = np.sqrt(np.maximum(np.diag(z_white), 1e-300))
    inflation = np.where(noise > 0.0, noise / white_deviation, 1.0)
    worst = max(1.0, float(inflation.max()))
    return Statistics(found, correlation, inflation, samples / worst**2, samples, tuple(directions))


def _involved(vector: Array, names: Sequence[str]) -> tuple[str, ...]:
    """Return the parameters of a direction, the largest component first."""
    size = np.abs(vector) / np.linalg.norm(vector)
    order = [int(k) for k in np.argsort(size)[::-1] if size[k] >= INVOLVED]
    return tuple(names[k] for k in order)


def long_run(scores: Sequence[Array]) -> Array:
    """Compute the long-run variance of sums of scores, shape (p, p): Newey-West, each stretch by itself."""
    p = scores[0].shape[1]
    total = np.zeros((p, p))
    for part in scores:
        total += part.T @ part
        width = bandwidth(part)
        for lag in range(1, width + 1):
            weight = 1.0 - lag / (width + 1.0)
            crossed = part[lag:].T @ part[:-lag]
            total += weight * (crossed + crossed.T)
    return total


def bandwidth(scores: Array) -> int:
    """Compute Andrews' automatic bandwidth of Bartlett's window, from autoregressions of the scores, shape (k, p)."""
    count = len(scores)
    above = below = 0.0
    for column in scores.T:
        size = float(column @ column)
        if size <= 0.0 or count < 20:
            continue
        rho = float(np.clip(column[1:] @ column[:-1] / size, -0.97, 0.97))
        # Each weighed by its inverse variance, so that all parameters count alike.
        above += 4.0 * rho**2 / ((1.0 - rho) ** 6 * (1.0 + rho) ** 2)
        below += 1.0 / (1.0 - rho) ** 4
    if below == 0.0:
        return 0
    return min(int(1.1447 * (above / below * count) ** (1.0 / 3.0)), count // 4)
