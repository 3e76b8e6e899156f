"""A path along resting tips: a spline through equilibria."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from tendond.daemon.control.reference.workspace import Surface, WorkspaceRest

Array = NDArray[np.float64]


class RestPath:
    """A cubic spline through equilibria, against a parameter that goes up in equal steps from 0 to `length`.

    Args:
        surface: surface of the equilibria.
        rests: two or more equilibria.
        length: last value of the parameter.
        elastic: the tendons stretch, which adds to their displacement.

    Attributes:
        POSITION, DIRECTION: columns of what `at` returns: [m] 3, [-] 3.
        POSITION_JACOBIAN, DIRECTION_JACOBIAN: their derivatives by the moment, 6 each, row by row.
        MOMENT, DISPLACEMENT: [N m] 2, [m] n.
    """

    POSITION, DIRECTION = slice(0, 3), slice(3, 6)
    POSITION_JACOBIAN, DIRECTION_JACOBIAN = slice(6, 12), slice(12, 18)
    MOMENT, DISPLACEMENT = slice(18, 20), slice(20, None)

    def __init__(self, surface: Surface, rests: Sequence[WorkspaceRest], length: float, *, elastic: bool) -> None:
        rows = [
            np.concatenate(
                [rest.place, rest.jacobian.ravel(), rest.moment, surface.rod.displacements(rest.state, elastic=elastic)]
            )
            for rest in rests
        ]
        self.length = length
        self.last = len(rests) - 1
        spline = CubicSpline(np.linspace(0.0, length, len(rests)), np.array(rows))
        self._step = length / self.last
        self._c3, self._c2, self._c1, self._c0 = np.ascontiguousarray(spline.c)

    def value(self, place: float) -> Array:
        """Return all columns at a value of the parameter, shape (20 + n,)."""
        k, x = self._piece(place)
        return np.asarray(self._c0[k] + x * (self._c1[k] + x * (self._c2[k] + x * self._c3[k])))

    def at(self, place: float) -> tuple[Array, Array, Array]:
        """Return all columns, their first and their second derivatives by the parameter; beyond the ends, the ends'."""
        k, x = self._piece(place)
        a, b, c, d = self._c3[k], self._c2[k], self._c1[k], self._c0[k]
        return d + x * (c + x * (b + x * a)), c + x * (2.0 * b + 3.0 * x * a), 2.0 * b + 6.0 * x * a

    def _piece(self, place: float) -> tuple[int, float]:
        """Return the piece of the spline, and the distance into it."""
        inside = min(max(place, 0.0), self.length)
        k = min(int(inside / self._step), self.last - 1)
        return k, inside - k * self._step
