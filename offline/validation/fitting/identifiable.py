"""Information of the data on each parameter: posterior beside prior, and pairs that they cannot tell apart."""

from dataclasses import dataclass

import numpy as np

from tendond.offline.validation.fitting.fit import Solution
from tendond.offline.validation.rods.parameters import Parameter

CORRELATED = 0.95
"""Correlation above which two parameters count as one that the data cannot divide."""

LEARNED = 0.8
"""Posterior sigma in parts of the prior's, above which the data say next to nothing of a parameter."""


@dataclass(frozen=True)
class Knowledge:
    """A fitted parameter.

    Attributes:
        name, unit: of it. value, sigma: of the fit. shrink: sigma in parts of the prior's. off: of the value from the
            prior's centre, in prior's sigmas.
    """

    name: str
    unit: str
    value: float
    sigma: float
    shrink: float
    off: float

    @property
    def identifiable(self) -> bool:
        """True if the data, not the prior, give the value."""
        return self.shrink < LEARNED


def knowledge_of(parameters: list[Parameter], solution: Solution, scale: float) -> list[Knowledge]:
    """Return each parameter's value and sigma; `scale` is the residuals' root mean square, in their sigmas."""
    deviation = scaled_deviations(solution, scale)
    found = []
    for one, z, sigma in zip(parameters, solution.z, deviation, strict=True):
        value = one.value(float(z))
        width = float(sigma) * one.sigma * (value if one.relative else 1.0)
        found.append(Knowledge(one.name, one.unit, value, width, float(sigma), float(z)))
    return found


def scaled_deviations(solution: Solution, scale: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return the sigmas of z by residuals that are `scale` times as large as they were weighed."""
    normal = solution.jacobian.T @ solution.jacobian / max(scale, 1e-9) ** 2 + np.eye(len(solution.z))
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(normal))))


def inseparable(parameters: list[Parameter], solution: Solution) -> list[tuple[str, str, float]]:
    """Return pairs of parameters with their correlation, the strongest first, where it exceeds CORRELATED."""
    covariance = solution.covariance
    deviation = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(deviation, deviation)
    pairs = [
        (parameters[i].name, parameters[j].name, float(correlation[i, j]))
        for i in range(len(parameters))
        for j in range(i)
        if abs(correlation[i, j]) > CORRELATED
    ]
    return sorted(pairs, key=lambda one: -abs(one[2]))
