"""Path lengths of the tendons for given strains, with their derivatives: kinematics and actuation in one.

A tendon's displacement is the shortening of its path; by virtual work its gradient is the tendon's generalised force.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import lean
from tendond.model.numerics.parked import park
from tendond.model.numerics.products import BLOCK, HALF, padded
from tendond.model.numerics.simd import simd_load, simd_multiply_add, simd_store
from tendond.model.strain.layout import Layout

Array = NDArray[np.float64]
Index = NDArray[np.int64]

ROUND = 1e-3
"""Part of the backbone's length: a path is rounded where it is shorter, at a centre of curvature.

A tendon's path has a kink there, where no minimum of an energy is smooth; elsewhere it is 5e-7 of its length off.
"""


class Paths(NamedTuple):
    """Displacements of the tendons, and what they follow from.

    Attributes:
        displacement: [m], shape (m,). gradient: by the modes, shape (m, n).
        first, last: modes that the strain at a tendon point has, as a range, shape (Q,).
        strain: at a point, shape (6,).
        routes: x, y, their slopes and the weight of the tendons at each point, side by side: five rows of L tendons, L
            a multiple of eight. tangent: unit tangent, and weight by length, four rows each.
        shortening, tension: of all tendons, L of them. pull: on a point's strain, six rows. turned: gradients, a row
            each mode.
        used: components that any mode has. modes: values of the modes at each point, a padded row for each of these
            components. spread: the same times the stiffness by strains, which is `block`, shape (6, 6). total: sum of
            products of both, padded rows.
    """

    displacement: Array
    gradient: Array
    first: Index
    last: Index
    strain: Array
    routes: Array
    tangent: Array
    shortening: Array
    tension: Array
    pull: Array
    turned: Array
    used: Index
    modes: Array
    spread: Array
    block: Array
    total: Array


def empty_paths(layout: Layout) -> Paths:
    """Return arrays for the tendons of this robot."""
    m, n = len(layout.straight), len(layout.component)
    used = layout.tendon_at != 0.0
    first = np.argmax(used, axis=1).astype(np.int64)
    last = (n - np.argmax(used[:, ::-1], axis=1)).astype(np.int64)
    points, width, columns = len(used), -(-m // HALF) * HALF, padded.py_func(n)
    routes = np.zeros((points, 5, width))
    routes[:, :2, :m], routes[:, 2:4, :m] = np.swapaxes(layout.route, 1, 2), np.swapaxes(layout.slope, 1, 2)
    routes[:, 4, :m] = layout.weight
    components = np.unique(layout.component)
    modes = np.zeros((points, len(components), columns))
    for row, component in enumerate(components):
        modes[:, row, :n] = layout.tendon_at * (layout.component == component)
    paths = Paths(
        displacement=np.zeros(m), gradient=np.zeros((m, n)), first=first, last=last, strain=np.zeros(6),
        routes=routes.reshape(-1), tangent=np.zeros(points * 4 * width), shortening=np.zeros(width),
        tension=np.zeros(width), pull=np.zeros(6 * width), turned=np.zeros(n * width), used=components,
        modes=modes.reshape(-1), spread=np.zeros(modes.size), block=np.zeros((6, 6)), total=np.zeros(columns**2),
    )  # fmt: skip
    return park(paths)


@lean
def find_paths(layout: Layout, q: Array, paths: Paths) -> None:
    """Write displacements and gradients for the strains q, shape (n,)."""
    n, width = len(q), len(paths.shortening)
    strain, pull, tangent, turned = paths.strain, paths.pull, paths.tangent, paths.turned
    paths.shortening[:], turned[:] = 0.0, 0.0
    for j in range(len(paths.first)):
        for c in range(6):
            strain[c] = layout.tendon_strain[j, c]
        for d in range(paths.first[j], paths.last[j]):
            strain[layout.component[d]] += layout.tendon_at[j, d] * q[d]
        u0, u1, u2, v0, v1, v2 = strain[0], strain[1], strain[2], strain[3], strain[4], strain[5]
        for lane in range(0, width, HALF):
            at, to = 5 * j * width + lane, 4 * j * width + lane
            x, y = simd_load(paths.routes, at, BLOCK), simd_load(paths.routes, at + width, BLOCK)
            tx = simd_load(paths.routes, at + 2 * width, BLOCK) + v0 - u2 * y
            ty = simd_load(paths.routes, at + 3 * width, BLOCK) + v1 + u2 * x
            tz = y * u0 - x * u1 + v2
            w = simd_load(paths.routes, at + 4 * width, BLOCK)
            length = math.sqrt(tx * tx + ty * ty + tz * tz + ROUND * ROUND)
            inverse = 1.0 / length
            tx, ty, tz = tx * inverse, ty * inverse, tz * inverse
            simd_store(tangent, to, tx)
            simd_store(tangent, to + width, ty)
            simd_store(tangent, to + 2 * width, tz)
            simd_store(tangent, to + 3 * width, w * inverse)
            short = simd_load(paths.shortening, lane, BLOCK)
            simd_store(paths.shortening, lane, short - w * (length - 0.5 * ROUND * ROUND))
            simd_store(pull, lane, w * y * tz)
            simd_store(pull, width + lane, -w * x * tz)
            simd_store(pull, 2 * width + lane, w * (x * ty - y * tx))
            simd_store(pull, 3 * width + lane, w * tx)
            simd_store(pull, 4 * width + lane, w * ty)
            simd_store(pull, 5 * width + lane, w * tz)
            for d in range(paths.first[j], paths.last[j]):
                now = simd_load(turned, d * width + lane, BLOCK)
                change = simd_load(pull, layout.component[d] * width + lane, BLOCK)
                simd_store(turned, d * width + lane, simd_multiply_add(-layout.tendon_at[j, d], change, now))
    for i in range(len(layout.straight)):
        paths.displacement[i] = layout.straight[i] + paths.shortening[i]
        for d in range(n):
            paths.gradient[i, d] = turned[d * width + i]
