"""Allocate a bending moment to tendon tensions: as little tension as possible, within bounds.

Tendons at r_i bend the rod by M = sum T_i r_i [N m] (a 2-vector that points to where the rod bends). Of all tensions
within the bounds that give M, those nearest to T_min are taken:

    minimise 1/2 sum (T_i - T_min)^2    subject to    sum T_i r_i = M,  T_min <= T_i <= T_max

a strictly convex quadratic program: one solution, continuous in M, also where one tendon takes over from another
(cf. Pott, Cable-Driven Parallel Robots, 2018, chapter 3). Its dual has two unknowns whatever the number of tendons,

    T_i = clip(T_min + r_i . y),    y minimises the convex, piecewise quadratic  sum h(r_i . y) - M . y,  h' = clip(...)

and Newton's method with an exact line search ends after a few pieces. The feasible moments are a zonogon (a polygon
with two parallel sides per tendon); a moment outside is replaced by the nearest one in it.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.model.numerics.compile import Bound, kernel

Array = NDArray[np.float64]

ROUNDING = 1e-12
"""Precision to which M is met, of the largest moment."""

RIDGE = 1e-9
"""Regularisation of the second derivative, of its size, where a piece is flat in one direction."""

EDGE = 1e-5
"""Distance of the moments from the edge of the feasible ones, of that to the middle: on it the dual has no minimum."""

NEWTON_STEPS = 100
"""Largest number of Newton steps: far above the pieces, of two kinks a tendon. Chosen; `pytest
tests/unit/model/test_allocation.py` draws up to 16 tendons."""


class Allocation:
    """Tensions for bending moments, of tendons at fixed places. Not for use by two threads at once: scratch memory.

    Args:
        positions: r_i in the cross-section [m], shape (n, 2).
        tension_min, tension_max: bounds of every tension [N].

    Raises:
        ParameterError: the tendons do not surround the rod, so that it cannot bend in some direction; or the bounds
            are empty.

    Attributes:
        arms: r_i, shape (2, n). shares: their pseudo-inverse, transposed: tensions per moment [1/m], shape (2, n).
        arm_max: size of the longest r_i [m]. tension_min, tension_max: as given.
        corners: corners of the polygon of feasible moments, counterclockwise [N m], shape (2 n, 2).
    """

    def __init__(self, positions: Sequence[tuple[float, float]], tension_min: float, tension_max: float) -> None:
        places = np.array(positions, dtype=np.float64)
        if not 0.0 <= tension_min < tension_max:
            raise ParameterError(f"tension_min = {tension_min} N must lie in [0, {tension_max}), below tension_max")
        if not surround(places):
            raise ParameterError(
                "the tendons do not surround the rod: to bend it to every side takes three or more, no two neighbours "
                "half a turn or more apart"
            )
        self.arms: Array = np.ascontiguousarray(places.T)
        self.shares: Array = np.ascontiguousarray(np.linalg.pinv(self.arms).T)
        self.arm_max = float(np.max(np.hypot(places[:, 0], places[:, 1])))
        self.tension_min, self.tension_max = tension_min, tension_max
        self.corners = _zonogon(places, tension_min, tension_max)
        middle = self.corners.mean(axis=0)
        self._inner = np.ascontiguousarray(middle + (1.0 - EDGE) * (self.corners - middle))
        self._scratch = np.zeros((3, 2 * len(places)))
        self._tendons = _Tendons(self.arms, float(tension_min), float(tension_max))
        self._allocate = Bound(allocate)
        self.tensions(np.zeros(2))  # compiles, which a control loop must not

    def moment(self, tensions: Array) -> Array:
        """M [N m], shape (2,), of tensions [N], shape (n,)."""
        return np.asarray((self.arms * tensions).sum(axis=1))

    def tensions(self, moment: Array) -> Array:
        """Tensions [N], shape (n,), for a moment [N m], shape (2,), or the nearest feasible one, within `EDGE`."""
        out = np.empty(self.arms.shape[1])
        self._allocate.call(self._tendons, self._inner, moment, self._scratch, out)
        return out

    def nearest(self, moment: Array) -> Array:
        """The feasible moment nearest to `moment` [N m], shape (2,)."""
        x, y = moment.tolist()
        return np.array(_nearest(self.corners, x, y))


def surround(places: Array) -> bool:
    """Return whether positive combinations of the tendons' places [m], shape (n, 2), give every direction."""
    off_axis = places[np.hypot(places[:, 0], places[:, 1]) > 0.0]
    if len(off_axis) < 3:
        return False
    angles = np.sort(np.arctan2(off_axis[:, 1], off_axis[:, 0]))
    gaps = np.diff(np.append(angles, angles[0] + 2.0 * math.pi))
    return bool(np.max(gaps) < math.pi - 1e-9)


def _zonogon(places: Array, tension_min: float, tension_max: float) -> Array:
    """Corners of all sums T_i r_i with bounded T_i, counterclockwise, shape (2 n, 2)."""
    sides = places * (tension_max - tension_min)
    sides = np.where((sides[:, 1:] < 0.0) | ((sides[:, 1:] == 0.0) & (sides[:, :1] < 0.0)), -sides, sides)
    sides = sides[np.argsort(np.arctan2(sides[:, 1], sides[:, 0]), kind="stable")]
    middle = places.sum(axis=0) * 0.5 * (tension_min + tension_max)
    lowest = middle - 0.5 * sides.sum(axis=0)
    half = lowest + np.cumsum(sides, axis=0)
    return np.ascontiguousarray(np.vstack([half, 2.0 * middle - half]))


class _Tendons(NamedTuple):
    """Tendons and bounds of their tension, as the kernels take them."""

    arms: Any  # r_i [m], shape (2, n)
    tension_min: float  # [N]
    tension_max: float  # [N]


class _Line(NamedTuple):
    """A line y + t d in the dual's plane, and the moment M [N m] of its objective."""

    M: tuple[float, float]
    y: tuple[float, float]
    d: tuple[float, float]


@kernel
def allocate(tendons: _Tendons, corners: Any, moment: Any, scratch: Any, out: Any) -> None:
    """Write the tensions for `moment` into `out`, shape (n,).

    Args:
        tendons: their places and bounds.
        corners: corners of the moments that are met [N m], shape (2 n, 2).
        moment: [N m], shape (2,).
        scratch: shape (3, 2 n).
        out: [N], written.
    """
    arms, tension_min, tension_max = tendons
    n = arms.shape[1]
    M = _nearest(corners, moment[0], moment[1])
    largest = 0.0
    for i in range(n):
        largest += math.hypot(arms[0, i], arms[1, i]) * tension_max
    y0, y1 = 0.0, 0.0
    for _ in range(NEWTON_STEPS):
        g0, g1, h00, h01, h11 = -M[0], -M[1], 0.0, 0.0, 0.0
        total = 0.0
        for i in range(n):
            a, b = arms[0, i], arms[1, i]
            free = tension_min + a * y0 + b * y1
            out[i] = min(max(free, tension_min), tension_max)
            g0 += a * out[i]
            g1 += b * out[i]
            total += a * a + b * b
            if tension_min <= free < tension_max:
                h00 += a * a
                h01 += a * b
                h11 += b * b
        if math.hypot(g0, g1) <= ROUNDING * largest:
            return
        h00 += RIDGE * total
        h11 += RIDGE * total
        determinant = h00 * h11 - h01 * h01
        d0, d1 = (h01 * g1 - h11 * g0) / determinant, (h01 * g0 - h00 * g1) / determinant
        along = _line_search(tendons, _Line(M, (y0, y1), (d0, d1)), ROUNDING * largest, scratch)
        y0 += along * d0
        y1 += along * d1


@kernel
def _line_search(tendons: _Tendons, line: _Line, rounding: float, scratch: Any) -> float:
    """Find the smallest t where the slope along the line, piecewise linear and not falling, is zero; or the last kink.

    A slope within `rounding` [N m] counts as zero: at the edge of the feasible moments it is zero from some kink on.
    """
    arms, tension_min, tension_max = tendons
    _, (y0, y1), (d0, d1) = line
    n = arms.shape[1]
    kinks, count = scratch[0], 0
    for i in range(n):
        rate = arms[0, i] * d0 + arms[1, i] * d1
        if rate == 0.0:
            continue
        free = arms[0, i] * y0 + arms[1, i] * y1
        for bound in (0.0, tension_max - tension_min):
            t = (bound - free) / rate
            if t > 0.0:
                place = count
                while place > 0 and kinks[place - 1] > t:
                    kinks[place] = kinks[place - 1]
                    place -= 1
                kinks[place] = t
                count += 1
    flat = 0.1 * rounding * math.hypot(d0, d1)
    before, slope_before = 0.0, _slope(tendons, line, 0.0)
    for k in range(count):
        slope = _slope(tendons, line, kinks[k])
        if slope >= 0.0:
            return float(before - slope_before * (kinks[k] - before) / (slope - slope_before))
        before, slope_before = kinks[k], slope
        if slope >= -flat:
            break
    return before


@kernel
def _slope(tendons: _Tendons, line: _Line, t: float) -> float:
    """Slope of the dual's objective along the line, at t."""
    arms, tension_min, tension_max = tendons
    (m0, m1), (y0, y1), (d0, d1) = line
    total = -(m0 * d0 + m1 * d1)
    for i in range(arms.shape[1]):
        a, b = arms[0, i], arms[1, i]
        free = tension_min + a * (y0 + t * d0) + b * (y1 + t * d1)
        total += (a * d0 + b * d1) * min(max(free, tension_min), tension_max)
    return float(total)


@kernel
def _nearest(corners: Any, x: float, y: float) -> tuple[float, float]:
    """The point of a convex polygon, counterclockwise, that is nearest to (x, y)."""
    count = corners.shape[0]
    outside, found, nearest_x, nearest_y = False, -1.0, x, y
    for k in range(count):
        x0, y0 = corners[k, 0], corners[k, 1]
        dx, dy = corners[(k + 1) % count, 0] - x0, corners[(k + 1) % count, 1] - y0
        square = dx * dx + dy * dy
        if square == 0.0:
            continue
        if dx * (y - y0) - dy * (x - x0) < 0.0:
            outside = True
        part = min(max(((x - x0) * dx + (y - y0) * dy) / square, 0.0), 1.0)
        px, py = x0 + part * dx, y0 + part * dy
        apart = (x - px) ** 2 + (y - py) ** 2
        if found < 0.0 or apart < found:
            found, nearest_x, nearest_y = apart, px, py
    if outside:
        return nearest_x, nearest_y
    return x, y
