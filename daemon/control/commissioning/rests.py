"""The rests that a right rig may have, and how far a measured one is from the nearest of them.

A right rig differs from the configuration by a weight that hangs on its tip, by its stiffness, by a base that is a
little turned or displaced, and by markers that sit a little askew on the tip. Weight and stiffness are a grid of
equilibria, computed once. The other three are small, and their likeliest values follow from the six measured numbers
in closed form: with the base turned by q and displaced by o, a rest (p, R) is seen at
(p + q x p + o, exp(a) exp(q) R). The misfit

    J = min over q of  |q|^2 / tilt^2 + |a|^2 / orientation^2 + |o|^2 / (offset L)^2

is a sum of squares in units of the tolerances: a right rig with its base turned and displaced by as much has J = 2.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.commissioning.rotations import rotation_vectors

Array = NDArray[np.float64]

MISFIT_MAX = 2.0
"""Misfit up to which a rest is right: base turned and displaced by its tolerance, both at once."""

FREE = 1e6
"""Factor by which a tolerance is widened that is not asked about."""


@dataclass(frozen=True)
class Tolerances:
    """Tolerances: `tilt` and `offset` of the base [rad, m], `orientation` of the markers on the tip [rad]."""

    tilt: float
    offset: float
    orientation: float


@dataclass(frozen=True)
class Fit:
    """The nearest rest of a right rig.

    Attributes:
        misfit: J.
        weight: mass on the tip [kg]. stiffness: ratio to the configuration's [-].
        position: position of that rest's tip [m], shape (3,).
        tilt: q, of the base [rad], shape (3,).
        offset: o, of the base [m], shape (3,).
    """

    misfit: float
    weight: float
    stiffness: float
    position: Array
    tilt: Array
    offset: Array

    @property
    def is_tolerated(self) -> bool:
        """True if a right rig may rest so."""
        return self.misfit <= MISFIT_MAX


@dataclass(frozen=True)
class RestFamily:
    """Rests under every weight and stiffness of a grid.

    Attributes:
        length: length of the rod [m].
        tolerances: bounds of what is not on the grid.
        weights: [kg], stiffnesses: [-], shapes (m,).
        positions: [m], shape (m, 3). rotations: shape (m, 3, 3).
    """

    length: float
    tolerances: Tolerances
    weights: Array
    stiffnesses: Array
    positions: Array
    rotations: Array

    def may_fit(self, position: Array) -> bool:
        """True if a tip there [m], shape (3,), can be one of a right rig: `fit` in a fraction of its time, too kind."""
        tolerances = MISFIT_MAX**0.5 * (self.tolerances.tilt * self.length + self.tolerances.offset)
        apart = self.positions - position
        return bool(np.min(np.einsum("mi,mi->m", apart, apart)) <= (2.0 * tolerances) ** 2)

    def fit(self, position: Array, rotation: Array, tolerances: Tolerances | None = None) -> Fit:
        """Fit the family to a measured rest.

        Args:
            position: position of the tip [m], shape (3,). rotation: rotation of it, shape (3, 3).
            tolerances: in place of the family's own.
        """
        tolerances = tolerances or self.tolerances
        p = self.positions
        turn = rotation_vectors(rotation @ self.rotations.transpose(0, 2, 1))
        apart = position - p
        stiff_t, stiff_o, stiff_p = tolerances.tilt**-2, tolerances.orientation**-2, tolerances.offset**-2
        square = np.einsum("mi,mi->m", p, p)
        matrix = stiff_p * (square[:, None, None] * np.eye(3) - np.einsum("mi,mj->mij", p, p))
        matrix += (stiff_t + stiff_o) * np.eye(3)
        q = np.linalg.solve(matrix, (stiff_o * turn + stiff_p * np.cross(p, apart))[..., None])[..., 0]
        rest, left = apart - np.cross(q, p), turn - q
        misfit = stiff_t * np.sum(q * q, 1) + stiff_o * np.sum(left * left, 1) + stiff_p * np.sum(rest * rest, 1)
        best = int(np.argmin(misfit))
        return Fit(
            float(misfit[best]), float(self.weights[best]), float(self.stiffnesses[best]), p[best], q[best], rest[best]
        )
