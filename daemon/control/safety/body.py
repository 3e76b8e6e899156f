"""Points and bends of the model's body, with their derivatives by its strains."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.body.points import PointWeights, find_points
from tendond.model.numerics.compile import Bound
from tendond.model.rods.general import GeneralRod
from tendond.model.strain.kinematics import empty_shape
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
        parts: of the points, parts of the length [-], shape (p,). weights: of the backbone's nodes in them.
        bend_rows: bending strain of the outermost fibre by the strains, about x and y, shape (b, 2, n).
    """

    def __init__(self, rod: GeneralRod, stations: tuple[float, ...]) -> None:
        self.parts: Array = np.array(sorted({*stations, 1.0}))
        self._layout, self._modes = rod.strain_rod.layout, rod.strain_rod.modes
        self.weights = PointWeights(*rod.backbone.weights(self.parts * rod.robot.length))
        self._room, self._find = empty_shape(self._layout), Bound(find_points)
        at, radii, start = [], [], 0.0
        for section in rod.robot.sections:
            for part in BEND_PLACES:
                inside = min(max(part, 1e-6), 1.0 - 1e-6) * section.length
                at.append(start + inside)
                radii.append(section.fibre(inside))
            start += section.length
        rows, _ = rod.backbone.bending(np.array(at))
        self.bend_rows: Array = rows.reshape(len(at), 2, -1) * np.array(radii)[:, None, None]

    def shape(self, state: StrainState) -> Shape:
        """Return points and bends of a state."""
        points, jacobians = np.empty((len(self.parts), 3)), np.empty((len(self.parts), 3, self._modes))
        self._find.call(self._layout, state.strain, self._room, self.weights, points, jacobians)
        return Shape(points, jacobians, self.bend_rows @ state.strain)
