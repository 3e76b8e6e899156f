"""Polynomial of the commands, by ridge regression: what a model without physics makes of the same inputs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.estimation.residual import exponents, monomials
from tendond.offline.correction.learned import ridge_solve

Array = NDArray[np.float64]
Index = NDArray[np.int64]

DEGREES = (1, 2, 3, 4, 5)
MOST = 250
"""Largest number of coefficients: nine commands have 220 up to the third degree."""

FOLDS = 5
RIDGES = (1e-8, 1e-6, 1e-4, 1e-2)
"""Penalties on the coefficients of normalised commands, in parts of the number of poses."""


@dataclass(frozen=True)
class Polynomial:
    """A fitted polynomial.

    Attributes:
        degree, ridge: chosen on the training part. coefficients: shape (C, 3) [m]. low, high: of the training commands
            [m], shape (m,).
    """

    degree: int
    ridge: float
    coefficients: Array
    low: Array
    high: Array

    def predict(self, command: Array) -> Array:
        """Return tips for commands [m], shape (N, 3)."""
        return np.asarray(monomials(_normalised(command, self.low, self.high), self.degree) @ self.coefficients)


def fit_polynomial(command: Array, tip: Array, block: Index) -> Polynomial:
    """Return the polynomial whose degree and penalty predict left-out blocks of the training part best."""
    low, high = command.min(axis=0), command.max(axis=0)
    inputs = _normalised(command, low, high)
    folds = np.searchsorted(np.unique(block), block) % FOLDS
    best = (np.inf, 1, RIDGES[0])
    for degree in DEGREES:
        if len(exponents(inputs.shape[1], degree)) > min(MOST, len(command) // 3):
            break
        features = monomials(inputs, degree)
        for ridge in RIDGES:
            error = 0.0
            for fold in np.unique(folds):
                out = folds == fold
                if out.all():
                    continue
                error += float(((features[out] @ ridge_solve(features[~out], tip[~out], ridge) - tip[out]) ** 2).sum())
            best = min(best, (error, degree, ridge))
    _, degree, ridge = best
    return Polynomial(degree, ridge, ridge_solve(monomials(inputs, degree), tip, ridge), low, high)


def _normalised(command: Array, low: Array, high: Array) -> Array:
    """Return commands as -1 to 1 over the training part's range."""
    return np.asarray(2.0 * (command - low) / np.maximum(high - low, 1e-12) - 1.0)
