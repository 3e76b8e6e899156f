"""Points and bends of the model's body, with their derivatives by its strains."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.rods.general import GeneralRod
from tendond.model.strain.state import StrainState

Array = NDArray[np.float64]

BEND_PLACES = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Places of each section at which its strain is watched, as parts of its length: its strains are polynomials."""


class Shape(NamedTuple):
    """Shape of the body.

    Attributes:
        points: [m], base's frame, shape (p, 3). jacobians: of them by the strains, shape (p, 3, n).
        bends: bending strain of the outermost fibre about x and y, by loads alone [-], shape (b, 2).
    """

    points: Array
    jacobians: Array
    bends: Array


class Body:
    """The places of a robot that constraints hold for.

    Args:
        rod: the model.
        stations: parts of its length [-]; the last one is the tip, and is added where it is missing.

    Attributes:
        parts: of the points, parts of the length [-], shape (p,).
        bend_rows: bending strain of the outermost fibre by the strains, about x and y, shape (b, 2, n).
    """

    def __init__(self, rod: GeneralRod, stations: tuple[float, ...]) -> None:
        self.parts: Array = np.array(sorted({*stations, 1.0}))
        self._rod = rod.strain_rod
        self._places, self._tangents = rod.backbone.weights(self.parts * rod.robot.length)
        at, radii, start = [], [], 0.0
        for section in rod.robot.sections:
            for part in BEND_PLACES:
                inside = min(max(part, 1e-6), 1.0 - 1e-6) * section.length
                at.append(start + inside)
                radii.append(section.fibre(inside))
            start += section.length
        rows, _ = rod.backbone.bending(np.array(at))
        self.bend_rows: Array = rows.reshape(len(at), 2, -1) * np.array(radii)[:, None, None]

    def points(self, state: StrainState) -> Array:
        """Return the points of a state [m], shape (p, 3), without their derivatives."""
        found = self._rod.shape(state)
        return np.asarray(self._places @ found.position + self._tangents @ found.rotation[:, 2::3])

    def shape(self, state: StrainState) -> Shape:
        """Return points and bends of a state."""
        found, n = self._rod.shape(state), self._rod.modes
        spin, drift = found.twist[:, :3, :n], found.twist[:, 3:, :n]
        ahead = found.rotation[:, 2::3]
        moved = _cross(spin, found.position) + drift
        turned = _cross(spin, ahead)
        points = self._places @ found.position + self._tangents @ ahead
        jacobians = np.tensordot(self._places, moved, 1) + np.tensordot(self._tangents, turned, 1)
        return Shape(points, jacobians, self.bend_rows @ state.strain)


def _cross(spin: Array, arm: Array) -> Array:
    """Return velocities of arms [m], shape (k, 3), by spins about the axes, shape (k, 3, n)."""
    x, y, z = (arm[:, axis, None] for axis in range(3))
    a, b, c = spin[:, 0], spin[:, 1], spin[:, 2]
    return np.stack((b * z - c * y, c * x - a * z, a * y - b * x), axis=1)
