"""Places along the backbone at which forces may act on the model: nodes with a mass point, evenly as they go."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.strain.rod import StrainRod

Array = NDArray[np.float64]

SECTION_STATIONS = 8
"""Stations of a section at most: about as many as it has nodes of its own, where it carries no disks. Chosen."""


@dataclass(frozen=True)
class BodyLoads:
    """Loads along the body, world frame.

    Attributes:
        moments: on the nodes [N m], shape (K + 1, 3). forces: on the stations [N], shape (p, 3).
    """

    moments: Array
    forces: Array


class Stations:
    """Places along a robot's backbone, from its base on; the last one is the tip.

    Args:
        rod: the robot's rod.

    Attributes:
        at: arc lengths [m], shape (p,). points: mass points there, shape (p,). nodes: shape (p,).
    """

    def __init__(self, rod: StrainRod) -> None:
        layout = rod.layout
        arcs = np.cumsum(layout.step)[layout.place - 1]
        on_axis = np.flatnonzero(~layout.arm.any(axis=1))
        _, first = np.unique(layout.place[on_axis], return_index=True)
        points = on_axis[first]
        most = SECTION_STATIONS * len(rod.robot.sections)
        while len(points) > most:  # the one whose neighbours are nearest to each other, but never the tip
            apart = arcs[points[1:]] - np.concatenate(([0.0], arcs[points[:-2]]))
            points = np.delete(points, int(np.argmin(apart)))
        self.points: NDArray[np.int64] = points.astype(np.int64)
        self.at: Array = arcs[self.points]
        self.nodes: NDArray[np.int64] = layout.place[self.points]

    def weights(self, place: float) -> Array:
        """Return the shares of a force at an arc length [m] that act on the stations beside it, shape (p,)."""
        right = min(int(np.searchsorted(self.at, place)), len(self.at) - 1)
        found = np.zeros(len(self.at))
        if right == 0:
            found[0] = 1.0
            return found
        share = min(max((place - self.at[right - 1]) / (self.at[right] - self.at[right - 1]), 0.0), 1.0)
        found[right - 1], found[right] = 1.0 - share, share
        return found
