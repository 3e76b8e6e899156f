"""Offset of a reference along the straight rod: under a load the tip with the same x is at another z."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.reference.goal import Goal
from tendond.schemas.record import ReferencePoint

Array = NDArray[np.float64]

FOLLOW_RATE = 0.4
"""Fraction per cycle by which a reference that may yield to loads follows the tip along the straight rod: with 0.05 a
hung weight is settled a quarter later, with 1 hardly sooner (`python -m tests.constants`)."""

OFFSET_MAX = 0.08
"""Largest such offset, of the rod's length: 100 g need 0.075 at the paper's target. Near the largest x the other shape
with the same x attracts a larger one: 0.2 ends 9 mm off, 0.4 in a tracking error (`python -m tests.constants`)."""

AT_TARGET = 0.1
"""Distance from the target, of the target, within which the tip has arrived and the reference may yield: 0.02 and 0.3
do as well (`python -m tests.constants`)."""


@dataclass(frozen=True)
class LoadOffset:
    """Rule by which a reference, of which the across component alone was asked for, follows the tip under a load.

    Attributes:
        axes: world axes across the straight rod, and along it.
        arrival: time from which on the reference rests at its target, or nearly [s].
        length: length of the rod [m].
    """

    axes: tuple[int, int]
    arrival: float
    length: float

    def advance(self, offset: float, position: Array, point: ReferencePoint, elapsed: float) -> float:
        """Return the offset [m] after a cycle; it changes only where the tip has arrived.

        Args:
            offset: so far [m].
            position: tip [m], shape (3,).
            point: the reference now, moved by the offset.
            elapsed: time since tracking began [s].
        """
        if elapsed < self.arrival:
            return offset
        across, along = self.axes
        place: list[float] = position.tolist()
        if abs(place[across] - point.position[across]) > AT_TARGET * abs(point.position[across]):
            return offset
        offset += FOLLOW_RATE * (place[along] - point.position[along])
        offset_max = OFFSET_MAX * self.length
        return min(offset_max, max(-offset_max, offset))


def moved_point(point: ReferencePoint, offset: float) -> ReferencePoint:
    """Return a point of the reference moved along the straight rod by an offset [m]."""
    if offset == 0.0:
        return point
    x, y, z = point.position
    return ReferencePoint.trusted(
        position=(x, y, z + offset), velocity=point.velocity, acceleration=point.acceleration, target=point.target
    )


def moved_goal(goal: Goal, offset: float) -> Goal:
    """Return a goal, a position, moved along the straight rod by an offset [m]."""
    return Goal(goal.place + np.array([0.0, 0.0, offset]), goal.jacobian) if offset else goal
