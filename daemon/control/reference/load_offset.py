"""Offset of a reference along the straight rod: under a load the tip with the same x is at another z."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.reference.goal import Goal
from tendond.model.rod.static_curve import StaticCurve
from tendond.schemas.record import ReferencePoint

Array = NDArray[np.float64]

FOLLOW_RATE = 0.4
"""Fraction per cycle by which a reference that may yield to loads follows the tip along the straight rod: with 0.05 a
hung weight is settled a quarter later, with 1 hardly sooner (`python -m tests.constants`)."""

OFFSET_RATE = 2.0
"""Rate at which the offset removes an error across, of a target where it cannot follow the tip [1/s]: a sixth of the
slowest law's, 12.5, so that the tip has settled along b_c meanwhile, and the two do not swing."""

STEADY = 0.9
"""Part of the offset that a move of the reference may return, for it to follow the tip; 1 is the limit of stability."""

OFFSET_GAIN_MAX = 10.0
"""Largest offset for an error across [-]: it is infinite where the curve of resting tips turns back."""

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
        gain: offset in a cycle for an error across [-], where it cannot follow the tip; see `offset_gain`.
    """

    axes: tuple[int, int]
    arrival: float
    length: float
    gain: float | None = None

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
        if self.gain is None:
            offset += FOLLOW_RATE * (place[along] - point.position[along])
        else:
            offset += self.gain * (place[across] - point.position[across])
        offset_max = OFFSET_MAX * self.length
        return min(offset_max, max(-offset_max, offset))


def offset_gain(curve: StaticCurve, arc: float, period: float) -> float | None:
    """Return `LoadOffset.gain` for a target, and none where the reference may follow the tip.

    The law holds b'(p - pd) = 0 with b the direction across the tip, (cos, -sin) of its angle, and the resting tip
    moves along the curve's tangent t. A move dz of the reference moves the tip by t bz dz / b't, and its z by the part
    bz tz / b't of dz. A reference that follows z so converges where this is below 1. It is above, as bx and tx differ
    in sign, where the tip points backwards but the curve has not yet turned back: between 90 and about 135 degrees.
    There x itself is driven to the target, with the inverse of dx/dz = tx bz / b't.

    Args:
        curve: resting tips. arc: of the target [m]. period: of the cycle [s].
    """
    angle, (tx, tz) = float(np.interp(arc, curve.arc, curve.angle)), curve.at(arc)[1].tolist()
    bx, bz = math.cos(angle), -math.sin(angle)
    along = bx * tx + bz * tz
    if bz * tz * along < STEADY * along * along:
        return None
    moved = tx * bz / along if along else 0.0
    inverse = 1.0 / moved if abs(moved) > 1.0 / OFFSET_GAIN_MAX else math.copysign(OFFSET_GAIN_MAX, moved)
    return -OFFSET_RATE * period * inverse


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
