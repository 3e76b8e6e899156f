"""Distances of a body's points to half-spaces and spheres along a motion, less what errors of the model take of them.

A distance is above zero where the point may be. A half-space with unit normal n, or a sphere about c:

    d = n.x - level,    d = sign (|x - c| - level)

A point that moves by u keeps `relative` |u| more than the margin, and `delay` times the longest of its moves between
samples; of bends v that change by e, a limit V keeps V - (1 + relative) |v + e| - relative |e|.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import kernel

Array = NDArray[np.float64]

CENTER_MIN = 1e-9
"""Distance from a sphere's center below which it has no direction [m]."""

MOVE_MIN = 1e-12
"""Move [m] or bend [-] below which it has no direction."""


class SurfaceRows(NamedTuple):
    """Surfaces with the points that they hold for, one row for each pair: half-spaces first, then spheres.

    Attributes:
        point: of each row, shape (r,). normal: of the half-spaces' rows [-], shape (a, 3); level: n.x there [m], (a,).
        center: of the spheres' rows [m], shape (r - a, 3); level_sphere: distance from it [m]; sign: 1 out, -1 in.
    """

    point: NDArray[np.intp]
    normal: Array
    level: Array
    center: Array
    level_sphere: Array
    sign: Array


class Kept(NamedTuple):
    """What is kept beside the surfaces.

    Attributes:
        margin: [m]. relative: of a motion [-]. delay: of the longest move between samples [-]. limit: of a bend [-].
    """

    margin: float
    relative: float
    delay: float
    limit: float


@kernel
def find_clearance(
    surfaces: SurfaceRows, kept: Kept, points: Array, bends: Array, moves: Array, turns: Array, weights: Array,
    clear: Array, slopes: Array, bend_slopes: Array, reach: Array,
) -> None:  # fmt: skip
    """Write the clearances along a motion.

    Args:
        points: now [m], shape (p, 3). bends: now [-], shape (b, 2). moves: of the points [m], shape (k, p, 3, c).
        turns: changes of the bends [-], shape (k, b, 2, c). weights: of the motions that these consist of, shape (c,).
        clear: clearances of surfaces [m], then of bends [-], shape (k, r + b).
        slopes: of the surfaces' by the move of their point [-], shape (k, r, 3).
        bend_slopes: of the bends' by their change [-], shape (k, b, 2).
        reach: longest move of each row's point [m], and largest change of each bend [-], shape (r + b,).
    """
    planes, count, steps = len(surfaces.level), len(surfaces.point), len(moves)
    moved, turned = np.zeros((steps, len(points), 3)), np.zeros((steps, len(bends), 2))
    for k in range(steps):
        for p in range(len(points)):
            for c in range(3):
                for i in range(len(weights)):
                    moved[k, p, c] += weights[i] * moves[k, p, c, i]
        for r in range(len(bends)):
            for c in range(2):
                for i in range(len(weights)):
                    turned[k, r, c] += weights[i] * turns[k, r, c, i]
    reach[:] = 0.0
    fastest = np.zeros(len(points))
    if kept.delay > 0.0:
        for p in range(len(points)):
            for k in range(steps):
                total = 0.0
                for c in range(3):
                    part = moved[k, p, c] - (moved[k - 1, p, c] if k > 0 else 0.0)
                    total += part * part
                fastest[p] = max(fastest[p], np.sqrt(total))
    for k in range(steps):
        for r in range(count):
            p = surfaces.point[r]
            u, v, w = moved[k, p, 0], moved[k, p, 1], moved[k, p, 2]
            x, y, z = points[p, 0] + u, points[p, 1] + v, points[p, 2] + w
            if r < planes:
                a, b, c = surfaces.normal[r, 0], surfaces.normal[r, 1], surfaces.normal[r, 2]
                distance = a * x + b * y + c * z - surfaces.level[r]
            else:
                s = r - planes
                a, b, c = x - surfaces.center[s, 0], y - surfaces.center[s, 1], z - surfaces.center[s, 2]
                length = np.sqrt(a * a + b * b + c * c)
                distance = surfaces.sign[s] * (length - surfaces.level_sphere[s])
                length = surfaces.sign[s] / max(length, CENTER_MIN)
                a, b, c = a * length, b * length, c * length
            far = np.sqrt(u * u + v * v + w * w)
            reach[r] = max(reach[r], far)
            clear[k, r] = distance - kept.margin - kept.relative * far - kept.delay * fastest[p]
            share = kept.relative / max(far, MOVE_MIN)
            slopes[k, r, 0], slopes[k, r, 1], slopes[k, r, 2] = a - share * u, b - share * v, c - share * w
        for r in range(len(bends)):
            u, v = turned[k, r, 0], turned[k, r, 1]
            x, y = bends[r, 0] + u, bends[r, 1] + v
            size, far = np.sqrt(x * x + y * y), np.sqrt(u * u + v * v)
            reach[count + r] = max(reach[count + r], far)
            clear[k, count + r] = kept.limit - (1.0 + kept.relative) * size - kept.relative * far
            one, two = (1.0 + kept.relative) / max(size, MOVE_MIN), kept.relative / max(far, MOVE_MIN)
            bend_slopes[k, r, 0], bend_slopes[k, r, 1] = -one * x - two * u, -one * y - two * v
