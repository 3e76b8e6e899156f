"""Rigid bodies on the tip: of a weight by its mass alone, and of two together."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendond.model.errors import ParameterError

Array = NDArray[np.float64]

BALL_DENSITY = 8500.0
"""Density of brass, of which laboratory weights are made [kg/m^3]."""


def ball_inertia(mass: float) -> tuple[float, float, float]:
    """Inertia of a brass ball about its centre [kg m^2], for a mass [kg]: 2/5 m r^2."""
    radius = (3.0 * mass / (4.0 * math.pi * BALL_DENSITY)) ** (1.0 / 3.0)
    inertia = 0.4 * mass * radius * radius
    return inertia, inertia, inertia


@dataclass(frozen=True)
class TipBody:
    """A rigid body on the tip.

    Attributes:
        mass: [kg].
        inertia: diagonal about its centre of mass, body frame [kg m^2], shape (3,).
        offset: vector from the tip to its centre of mass, body frame [m], shape (3,).
    """

    mass: float
    inertia: Array
    offset: Array

    @classmethod
    def checked(cls, mass: float, inertia: ArrayLike, offset: ArrayLike) -> "TipBody":
        """A body of these values.

        Raises:
            ParameterError: a negative or non-finite mass or inertia, an offset that is not finite.
        """
        J, c = np.asarray(inertia, dtype=np.float64), np.asarray(offset, dtype=np.float64)
        if not (0.0 <= mass < math.inf and np.all(J >= 0.0) and np.all(np.isfinite(J)) and np.all(np.isfinite(c))):
            raise ParameterError(f"a body of {mass} kg on the tip must have a finite mass and inertia, not below 0")
        return cls(mass, J, c)

    def __add__(self, other: "TipBody") -> "TipBody":
        """Both bodies as one, by the parallel axis theorem.

        Products of inertia are left out: bodies lie on the rod's axis, or are small beside the rod.
        """
        mass = self.mass + other.mass
        centre = (self.mass * self.offset + other.mass * other.offset) / mass if mass > 0.0 else np.zeros(3)
        inertia = (
            self.inertia
            + self.mass * _square_distance(self.offset - centre)
            + other.inertia
            + other.mass * _square_distance(other.offset - centre)
        )
        return TipBody(mass, inertia, centre)


def _square_distance(arm: Array) -> Array:
    """Squared distance of a point from each body axis [m^2], shape (3,)."""
    x, y, z = arm.tolist()
    return np.array([y * y + z * z, x * x + z * z, x * x + y * y])
