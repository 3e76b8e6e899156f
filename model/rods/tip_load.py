"""A mass on the tip beside the robot's own: a tool that is heavier than described, or something that hangs there."""

import numpy as np
from numpy.typing import NDArray

from tendond.model.strain.rod import StrainRod

Array = NDArray[np.float64]

LIGHTEST = 0.1
"""Least part of the described mass on the tip that is believed to be there. Chosen."""


class TipLoad:
    """Mass points that share a mass on the tip: those of the bodies there, by their masses; without one, the tip.

    Args:
        rod: the robot's rod.

    Attributes:
        points: of the layout, shape (p,). shares: of the mass in each, which sum up to one, shape (p,).
        least: smallest mass beside the robot's own that leaves some of that [kg], not above 0.
    """

    def __init__(self, rod: StrainRod) -> None:
        layout, length = rod.layout, rod.robot.length
        bodies = [one for one in rod.robot.bodies if one.mass > 0.0 and abs(one.at - length) <= 1e-9 * length]
        node, tip = rod.node(length)
        at = np.flatnonzero(layout.place == node)
        masses = np.zeros(len(layout.mass))
        for mass, arm in (one for body in bodies for one in body.points()):
            masses[at[np.argmin(np.linalg.norm(layout.arm[at] - arm, axis=1))]] += mass
        total = float(masses.sum())
        if total == 0.0:
            masses[tip] = 1.0
        self.points: NDArray[np.int64] = np.flatnonzero(masses)
        self.shares: Array = masses[self.points] / masses.sum()
        self.least = -(1.0 - LIGHTEST) * total
        self._layout, self._own, self._more = layout, layout.mass[self.points], 0.0

    def put(self, mass: float) -> None:
        """Let the kernels take a mass beside the robot's own [kg]."""
        if mass != self._more:
            self._layout.mass[self.points] = self._own + mass * self.shares
            self._more = mass
