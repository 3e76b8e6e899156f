"""From a bending moment to tensions of the tendons: least effort, never below the pretension, never above the limit.

Tendons at r_i bend the rod by M = sum T_i r_i [N m] (a 2-vector, which points to where the rod bends).
Of all tensions between `least` and `most` that give M, those nearest to `least` are taken:

    minimise 1/2 sum (T_i - least)^2    subject to    sum T_i r_i = M,  least <= T_i <= most

a strictly convex quadratic program: one solution, continuous in M, also where one tendon takes over from another
(cf. Pott, Cable-Driven Parallel Robots, 2018, chapter 3). Its dual has two unknowns whatever the number of tendons,

    T_i = clip(least + r_i . y),    y minimises the convex, piecewise quadratic  sum h(r_i . y) - M . y,  h' = clip(...)

and Newton's method with an exact line search ends after a few pieces. The moments that can be had are a zonogon
(a polygon with two parallel sides per tendon); a moment outside is replaced by the nearest one in it.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.model.numerics.compile import bind, kernel

Array = NDArray[np.float64]

ROUNDING = 1e-12
"""Of the largest moment: M is met to this."""

RIDGE = 1e-9
"""Added to the second derivative, of its size, where a piece is flat in one direction."""

EDGE = 1e-5
"""Part of the way to the middle by which moments keep off the edge of what can be had: there is no dual minimum."""

NEWTON_STEPS = 100


class Allocation:
    """Tensions for bending moments, of tendons at fixed places. Not for use by two threads at once: scratch memory.

    Args:
        positions: r_i in the cross-section [m], shape (n, 2).
        least, most: bounds of every tension [N].

    Raises:
        ParameterError: the tendons do not surround the rod, so that some direction cannot be bent to; or the bounds
            leave no room.

    Attributes:
        arms: r_i, shape (2, n). shares: their pseudo-inverse, transposed: tensions per moment [1/m], shape (2, n).
        longest: size of the longest r_i [m]. least, most: as given.
        corners: of the polygon of moments that can be had, counterclockwise [N m], shape (2 n, 2).
    """

    def __init__(self, positions: Sequence[tuple[float, float]], least: float, most: float) -> None:
        places = np.array(positions, dtype=np.float64)
        if not 0.0 <= least < most:
            raise ParameterError(f"the least tension {least} N must lie in [0, {most}), below the largest")
        if not _surround(places):
            raise ParameterError(
                "the tendons do not surround the rod: to bend it to every side takes three or more, no two neighbours "
                "half a turn or more apart"
            )
        self.arms: Array = np.ascontiguousarray(places.T)
        self.shares: Array = np.ascontiguousarray(np.linalg.pinv(self.arms).T)
        self.longest = float(np.max(np.hypot(places[:, 0], places[:, 1])))
        self.least, self.most = least, most
        self.corners = _zonogon(places, least, most)
        middle = self.corners.mean(axis=0)
        self._inner = np.ascontiguousarray(middle + (1.0 - EDGE) * (self.corners - middle))
        self._scratch = np.zeros((3, 2 * len(places)))
        self._allocate: Any = None
        self.tensions(np.zeros(2))  # compiles, which a control loop must not

    def moment(self, tensions: Array) -> Array:
        """M of tensions [N], shape (n,), in N m, shape (2,)."""
        return np.asarray((self.arms * tensions).sum(axis=1))

    def tensions(self, moment: Array) -> Array:
        """Tensions [N], shape (n,), for a moment [N m], shape (2,), or the nearest to be had, within `EDGE`."""
        out = np.empty(self.arms.shape[1])
        arguments = (self.arms, self.least, self.most, self._inner, moment, self._scratch, out)
        if self._allocate is None:
            self._allocate = bind(allocate, *arguments)
        self._allocate(*arguments)
        return out

    def nearest(self, moment: Array) -> Array:
        """`moment` [N m], shape (2,), or the nearest to it that can be had."""
        x, y = moment.tolist()
        return np.array(_nearest(self.corners, x, y))


def _surround(places: Array) -> bool:
    """Whether positive combinations of the places give every direction."""
    far = places[np.hypot(places[:, 0], places[:, 1]) > 0.0]
    if len(far) < 3:
        return False
    angles = np.sort(np.arctan2(far[:, 1], far[:, 0]))
    gaps = np.diff(np.append(angles, angles[0] + 2.0 * math.pi))
    return bool(np.max(gaps) < math.pi - 1e-9)


def _zonogon(places: Array, least: float, most: float) -> Array:
    """Corners of all sums T_i r_i with bounded T_i, counterclockwise, shape (2 n, 2)."""
    sides = places * (most - least)
    sides = np.where((sides[:, 1:] < 0.0) | ((sides[:, 1:] == 0.0) & (sides[:, :1] < 0.0)), -sides, sides)
    sides = sides[np.argsort(np.arctan2(sides[:, 1], sides[:, 0]), kind="stable")]
    middle = places.sum(axis=0) * 0.5 * (least + most)
    lowest = middle - 0.5 * sides.sum(axis=0)
    half = lowest + np.cumsum(sides, axis=0)
    return np.ascontiguousarray(np.vstack([half, 2.0 * middle - half]))


@kernel
def allocate(arms: Any, least: float, most: float, corners: Any, moment: Any, scratch: Any, out: Any) -> None:
    """Write the tensions for `moment` into `out`, shape (n,).

    Args:
        arms: [m], shape (2, n). corners: of the moments that are met, shape (2 n, 2).
        scratch: shape (3, 2 n).
    """
    n = arms.shape[1]
    wanted_x, wanted_y = _nearest(corners, moment[0], moment[1])
    largest = 0.0
    for i in range(n):
        largest += math.hypot(arms[0, i], arms[1, i]) * most
    y0, y1 = 0.0, 0.0
    for _ in range(NEWTON_STEPS):
        g0, g1, h00, h01, h11 = -wanted_x, -wanted_y, 0.0, 0.0, 0.0
        total = 0.0
        for i in range(n):
            a, b = arms[0, i], arms[1, i]
            free = least + a * y0 + b * y1
            out[i] = min(max(free, least), most)
            g0 += a * out[i]
            g1 += b * out[i]
            total += a * a + b * b
            if least <= free < most:
                h00 += a * a
                h01 += a * b
                h11 += b * b
        if math.hypot(g0, g1) <= ROUNDING * largest:
            return
        h00 += RIDGE * total
        h11 += RIDGE * total
        determinant = h00 * h11 - h01 * h01
        d0, d1 = (h01 * g1 - h11 * g0) / determinant, (h01 * g0 - h00 * g1) / determinant
        along = _line_search(arms, least, most, wanted_x, wanted_y, y0, y1, d0, d1, ROUNDING * largest, scratch)
        y0 += along * d0
        y1 += along * d1


@kernel
def _line_search(
    arms: Any, least: float, most: float, m0: float, m1: float, y0: float, y1: float, d0: float, d1: float,
    rounding: float, scratch: Any,
) -> float:  # fmt: skip
    """Where the slope along y + t d, piecewise linear and not falling, is zero: the least t, or the last kink.

    A slope within `rounding` [N m] counts as zero: at the edge of what can be had, it is zero from some kink on.
    """
    n = arms.shape[1]
    kinks, count = scratch[0], 0
    for i in range(n):
        rate = arms[0, i] * d0 + arms[1, i] * d1
        if rate == 0.0:
            continue
        free = arms[0, i] * y0 + arms[1, i] * y1
        for bound in (0.0, most - least):
            t = (bound - free) / rate
            if t > 0.0:
                place = count
                while place > 0 and kinks[place - 1] > t:
                    kinks[place] = kinks[place - 1]
                    place -= 1
                kinks[place] = t
                count += 1
    flat = 0.1 * rounding * math.hypot(d0, d1)
    before, slope_before = 0.0, _slope(arms, least, most, m0, m1, y0, y1, d0, d1, 0.0)
    for k in range(count):
        slope = _slope(arms, least, most, m0, m1, y0, y1, d0, d1, kinks[k])
        if slope >= 0.0:
            return float(before - slope_before * (kinks[k] - before) / (slope - slope_before))
        before, slope_before = kinks[k], slope
        if slope >= -flat:
            break
    return before


@kernel
def _slope(
    arms: Any, least: float, most: float, m0: float, m1: float, y0: float, y1: float, d0: float, d1: float, t: float
) -> float:
    total = -(m0 * d0 + m1 * d1)
    for i in range(arms.shape[1]):
        a, b = arms[0, i], arms[1, i]
        free = least + a * (y0 + t * d0) + b * (y1 + t * d1)
        total += (a * d0 + b * d1) * min(max(free, least), most)
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
