"""A learned correction of the model's tip, from the tendons' displacements: small, named features, bounded.

What a model leaves of a measured robot is, to a part, a function of what its tendons were drawn to. The features are
products of the displacements, normalised to -1 to 1 over what was learned from, and the side of its play on which each
tendon is. The correction is no longer than a bound, and fades out beside the displacements that it was learned from.
"""

from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.schemas.config.observer import ResidualSection

Array = NDArray[np.float64]

MARGIN = 0.1
"""Part of a displacement's range beyond it over which the correction goes to zero."""


def exponents(inputs: int, degree: int) -> list[tuple[int, ...]]:
    """Return the inputs of each product, up to a degree: () is the constant."""
    return [one for n in range(degree + 1) for one in combinations_with_replacement(range(inputs), n)]


def monomials(inputs: Array, degree: int) -> Array:
    """Return all products of up to `degree` inputs, shape (N, C)."""
    return np.stack([np.prod(inputs[:, list(one)], axis=1) for one in exponents(inputs.shape[1], degree)], axis=1)


def feature_names(tendons: int, degree: int) -> list[str]:
    """Return the features' names: "1", "c0", "c0*c2", ..., "side0", ..."""
    products = ["*".join(f"c{i}" for i in one) or "1" for one in exponents(tendons, degree)]
    return products + [f"side{i}" for i in range(tendons)]


@dataclass(frozen=True)
class Residual:
    """Correction that is added to a model's tip.

    Attributes:
        degree: of the products. width: half-width of the play that decides on the sides [m].
        features: names, F. coefficients: of them [m], shape (F, 3).
        low, high: of the displacements that it was learned from [m], shape (n,). bound: of the correction's length [m].

    Raises:
        ParameterError: sizes that do not fit, other features than this version's, or what is not finite.
    """

    degree: int
    width: float
    features: tuple[str, ...]
    coefficients: Array
    low: Array
    high: Array
    bound: float

    def __post_init__(self) -> None:
        tendons = len(self.low)
        if list(self.features) != feature_names(tendons, self.degree):
            raise ParameterError(f"residual: features are not those of {tendons} tendons and degree {self.degree}")
        if np.shape(self.coefficients) != (len(self.features), 3) or np.shape(self.high) != (tendons,):
            raise ParameterError("residual: coefficients has a row of x, y, z for each feature, high as many as low")
        numbers = (self.coefficients, self.low, self.high, self.width, self.bound)
        if not all(np.all(np.isfinite(one)) for one in numbers) or not (self.width > 0.0 <= self.bound):
            raise ParameterError("residual: its numbers must be finite, width positive and bound not negative")

    def play(self, held: Array, displacement: Array) -> Array:
        """Return the play operator's state after a displacement [m], shape (n,); it starts at the first one."""
        return np.minimum(np.maximum(held, displacement - self.width), displacement + self.width)

    def features_at(self, displacement: Array, held: Array) -> Array:
        """Return the features at displacements with the play's states beside them [m], shapes (N, n); shape (N, F)."""
        inputs = 2.0 * (displacement - self.low) / np.maximum(self.high - self.low, 1e-12) - 1.0
        sides = (held - displacement) / self.width
        return np.hstack([monomials(np.clip(inputs, -1.2, 1.2), self.degree), sides])

    def shift(self, displacement: Array, held: Array) -> Array:
        """Return the correction [m], shape (N, 3); arguments as in `features_at`."""
        raw = self.features_at(displacement, held) @ self.coefficients
        size = np.linalg.norm(raw, axis=1)
        bounded = raw * np.minimum(1.0, self.bound / np.maximum(size, 1e-12))[:, None]
        reach = np.maximum(self.high - self.low, 1e-12)
        outside = np.maximum(np.maximum(self.low - displacement, displacement - self.high), 0.0)
        beyond = np.max(outside / reach, axis=1)
        return np.asarray(bounded * np.clip(1.0 - beyond / MARGIN, 0.0, 1.0)[:, None])

    def along(self, displacement: Array) -> Array:
        """Return the play's states along a sequence of displacements [m], shapes (N, n)."""
        held, found = displacement[0].copy(), np.empty_like(displacement)
        for i, now in enumerate(displacement):
            held = found[i] = self.play(held, now)
        return found


def residual_of(section: ResidualSection) -> Residual:
    """Return the correction that [observer.residual] holds.

    Raises:
        ParameterError: see `Residual`.
    """
    coefficients, low, high = (np.array(one) for one in (section.coefficients, section.low, section.high))
    return Residual(section.degree, section.width, section.features, coefficients, low, high, section.bound)
