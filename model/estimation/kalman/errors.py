"""The errors that the estimator keeps account of, and where each stands in their vector."""

import numpy as np
from numpy.typing import NDArray

from tendond.model.strain.discretise.modes import BENDING_Y, TORSION
from tendond.model.strain.rod import StrainRod

Array = NDArray[np.float64]
Index = NDArray[np.int64]

BENDING_ORDERS, TORSION_ORDERS = 3, 2
"""Strain modes of a section in which errors are followed: a quadratic bend, a linear twist. The model has all modes; an
error in a finer one, which is stiffer by far, comes and goes with its cause."""


class ErrorLayout:
    """Errors of strains, their rates, the tip force, tensions, bending moments, stiffness and tip mass, in this order.

    The moments go linearly from -1 to 1 along each section, across both of its axes: what tensions that fall along the
    tendons do beside those at the servos, and a robot that is not as uniform as its model.

    Args:
        rod: the robot's rod. tip_mass: there is an error of the mass on the tip.

    Attributes:
        kept: strain modes that have an error, k of n. size: N, of all errors.
        strain, rate, force, tension, bend, tip_mass: places in the vector, as slices. stiffness: likewise, an index.
        drive: of those of tensions and moments among those beyond the rates, as a slice.
        bends: of `kept`, the modes that the moments bend, shape (b,); arms: per unit of moment [m], shape (b,).
    """

    def __init__(self, rod: StrainRod, tip_mass: bool = False) -> None:
        component, order = rod.layout.component, rod.layout.order
        bends = (component <= BENDING_Y) & (order < BENDING_ORDERS)
        twists = (component == TORSION) & (order < TORSION_ORDERS)
        self.kept: Index = np.flatnonzero(bends | twists).astype(np.int64)
        k, m = len(self.kept), len(rod.robot.tendons)
        self.strain, self.rate = slice(0, k), slice(k, 2 * k)
        self.force, self.tension = slice(2 * k, 2 * k + 3), slice(2 * k + 3, 2 * k + 3 + m)
        self.bends: Index = np.flatnonzero((component[self.kept] <= BENDING_Y) & (order[self.kept] == 1)).astype(
            np.int64
        )
        lengths = [section.length for section in rod.robot.sections for _ in range(2)]
        self.arms = np.array(lengths) / 3.0  # integral of the squared linear polynomial
        layout = rod.layout
        at = 0.5 * (layout.at1 + layout.at2)[:, self.kept[self.bends]]  # of the linear polynomials, shape (K, b)
        self._profile = at[:, :, None] * np.eye(3)[component[self.kept[self.bends]]]
        self.bend = slice(self.tension.stop, self.tension.stop + len(self.bends))
        self.drive = slice(3, self.bend.stop - 2 * k)
        self.stiffness = self.bend.stop
        self.tip_mass = slice(self.stiffness + 1, self.stiffness + 1 + tip_mass)
        self.size = self.tip_mass.stop

    def tip_mass_of(self, errors: Array) -> float:
        """Return the mass on the tip [kg] of errors, shape (N,); zero where it has none."""
        return float(errors[self.tip_mass].sum())

    def inner_moments(self, bend: Array) -> Array:
        """Return the bending moments of each interval, in the frame of its cross-section [N m], shape (K, 3)."""
        return np.asarray(np.einsum("kbc,b->kc", self._profile, bend))
