"""A path of poses: a spline through equilibria of a robot of sections."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from tendond.daemon.control.pose.pose import Pose
from tendond.daemon.control.pose.rests import PoseRest
from tendond.model.rods.general import GeneralRod

Array = NDArray[np.float64]

POSITION, TURN = slice(0, 3), slice(3, 7)
"""Columns of a path: position [m] and quaternion x, y, z, w of the tip; behind them displacements [m], tensions [N]."""


class PosePath:
    """A cubic spline through equilibria, against a parameter that goes up in equal steps from 0 to `length`.

    Args:
        rod: the controller's model.
        rests: two or more equilibria.
        length: last value of the parameter.
        elastic: the tendons stretch, which adds to their displacement.

    Attributes:
        length: as given. last: number of pieces.
        displacement, tension: columns of `at` with the tendons' displacements [m] and tensions [N].
    """

    def __init__(self, rod: GeneralRod, rests: Sequence[PoseRest], length: float, *, elastic: bool) -> None:
        count = len(rests[0].tension)
        turns = Rotation.from_matrix(np.array([rest.pose.rotation for rest in rests])).as_quat()
        for k in range(1, len(turns)):
            if float(turns[k] @ turns[k - 1]) < 0.0:  # the same rotation, without a jump of the quaternion
                turns[k] = -turns[k]
        rows = [
            np.concatenate((rest.pose.position, turn, rod.displacements(rest.state, elastic=elastic), rest.tension))
            for rest, turn in zip(rests, turns, strict=True)
        ]
        self.length, self.last = length, len(rests) - 1
        self.displacement, self.tension = slice(7, 7 + count), slice(7 + count, 7 + 2 * count)
        spline = CubicSpline(np.linspace(0.0, length, len(rests)), np.array(rows))
        self._step = length / self.last
        self._c3, self._c2, self._c1, self._c0 = np.ascontiguousarray(spline.c)

    def at(self, place: float) -> tuple[Array, Array, Array]:
        """Return all columns, their first and their second derivatives by the parameter; beyond the ends, the ends'."""
        inside = min(max(place, 0.0), self.length)
        k = min(int(inside / self._step), self.last - 1)
        x = inside - k * self._step
        a, b, c, d = self._c3[k], self._c2[k], self._c1[k], self._c0[k]
        return d + x * (c + x * (b + x * a)), c + x * (2.0 * b + 3.0 * x * a), 2.0 * b + 6.0 * x * a

    @staticmethod
    def pose(row: Array) -> Pose:
        """Return the pose in a row of columns."""
        return Pose(row[POSITION].copy(), np.asarray(Rotation.from_quat(row[TURN]).as_matrix()))
