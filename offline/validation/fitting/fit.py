"""Maximum a posteriori fit of parameters with normal priors: Gauss-Newton, damped where it must."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ConvergenceError, ParameterError

Array = NDArray[np.float64]
Residuals = Callable[[Array], Array]
"""Errors in units of their sigma, shape (R,), of parameters in sigmas of their priors, shape (P,)."""

STEP = 1e-3
"""Step of the difference quotients, in sigmas of the priors. Chosen: a hundred times what makes the tip move by the
tolerance of a rest."""

ITERATIONS = 30
GAIN = 1e-3
"""Relative decrease of the objective below which the fit ends, unless its step was damped. Chosen: in RMS, a part
of two thousand."""

LIGHT = 1e-2
"""Damping, in parts of the normal matrix's diagonal, that leaves a step nearly whole."""


@dataclass(frozen=True)
class Solution:
    """The most probable parameters.

    Attributes:
        z: in sigmas of the priors, shape (P,). residuals: in sigmas, shape (R,). jacobian: of them, shape (R, P).
        cost: sum of squares of residuals and of z.
    """

    z: Array
    residuals: Array
    jacobian: Array
    cost: float

    @property
    def covariance(self) -> Array:
        """Covariance of z by the data and the priors, shape (P, P)."""
        return np.asarray(np.linalg.inv(self.jacobian.T @ self.jacobian + np.eye(len(self.z))))


def jacobian_of(residuals: Residuals, z: Array, at: Array) -> Array:
    """Return the derivative of the residuals, `at` being those at z, shape (R, P)."""
    columns = []
    for index in range(len(z)):
        moved = z.copy()
        moved[index] += STEP
        columns.append((residuals(moved) - at) / STEP)
    return np.stack(columns, axis=1) if columns else np.zeros((len(at), 0))


def fit(residuals: Residuals, start: Array, iterations: int = ITERATIONS) -> Solution:
    """Return the minimum of |residuals(z)|^2 + |z|^2 from a start, shape (P,)."""
    z, damping = start.copy(), 1e-3
    now = residuals(z)
    cost = float(now @ now + z @ z)
    jacobian = jacobian_of(residuals, z, now)
    for _ in range(iterations):
        normal = jacobian.T @ jacobian + np.eye(len(z))
        gradient = jacobian.T @ now + z
        before = cost
        for _ in range(8):
            step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), -gradient)
            step *= min(1.0, 3.0 / max(float(np.max(np.abs(step))), 1e-12))  # no further than the priors reach
            try:
                there = residuals(z + step)
            except (ConvergenceError, ParameterError):
                damping *= 10.0
                continue
            found = float(there @ there + (z + step) @ (z + step))
            if found < cost:
                z, now, cost = z + step, there, found
                damping = max(damping / 10.0, 1e-9)
                break
            damping *= 10.0
        if before == cost or (before - cost <= GAIN * cost and damping < LIGHT):
            break
        jacobian = jacobian_of(residuals, z, now)
    return Solution(z, now, jacobian_of(residuals, z, now), cost)
