"""Path lengths of the tendons for given strains, with first and second derivatives: kinematics and actuation in one.

A tendon's displacement is the shortening of its path; by virtual work its gradient is the tendon's generalised force.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import lean
from tendond.model.numerics.parked import park
from tendond.model.numerics.products import BLOCK, HALF
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
        strain: at a point, shape (6,). block: stiffness by strains, shape (6, 6). spread: a row of it by modes,
            shape (n,).
        routes: x, y, their slopes and the weight of the tendons at each point, side by side: five rows of L tendons, L
            a multiple of eight. tangent: unit tangent, and weight by length, four rows each.
        shortening: of all tendons, L of them. pull: on a point's strain, six rows. turned: gradients, a row each mode.
    """

    displacement: Array
    gradient: Array
    first: Index
    last: Index
    strain: Array
    block: Array
    spread: Array
    routes: Array
    tangent: Array
    shortening: Array
    pull: Array
    turned: Array


def empty_paths(layout: Layout) -> Paths:
    """Return arrays for the tendons of this robot."""
    m, n = len(layout.straight), len(layout.component)
    used = layout.tendon_at != 0.0
    first = np.argmax(used, axis=1).astype(np.int64)
    last = (n - np.argmax(used[:, ::-1], axis=1)).astype(np.int64)
    points, width = len(used), -(-m // HALF) * HALF
    routes = np.zeros((points, 5, width))
    routes[:, :2, :m], routes[:, 2:4, :m] = np.swapaxes(layout.route, 1, 2), np.swapaxes(layout.slope, 1, 2)
    routes[:, 4, :m] = layout.weight
    paths = Paths(
        np.zeros(m), np.zeros((m, n)), first, last, np.zeros(6), np.zeros((6, 6)), np.zeros(n), routes.reshape(-1),
        np.zeros(points * 4 * width), np.zeros(width), np.zeros(6 * width), np.zeros(n * width),
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


@lean
def add_tendon_stiffness(layout: Layout, q: Array, tension: Array, factor: float, paths: Paths, out: Array) -> None:
    """Subtract `factor` times the sum of tension . d2(displacement)/dq dq from `out`, shape (n, n).

    After `find_paths` at the same strains q, whose tangents it takes.
    """
    block, spread, tangent, width = paths.block, paths.spread, paths.tangent, len(paths.shortening)
    for j in range(len(paths.first)):
        any_tension = False
        for i in range(len(tension)):
            any_tension |= layout.weight[j, i] * tension[i] != 0.0
        if not any_tension:
            continue
        first, last = paths.first[j], paths.last[j]
        sheared = False
        for d in range(first, last):
            sheared |= layout.component[d] == 3 or layout.component[d] == 4
        b00 = b10 = b11 = b20 = b21 = b22 = b50 = b51 = b52 = b55 = 0.0
        b30 = b31 = b32 = b33 = b40 = b41 = b42 = b43 = b44 = b53 = b54 = 0.0
        for i in range(len(tension)):
            at = 4 * j * width + i
            w = tangent[at + 3 * width] * tension[i] * factor
            if w == 0.0:
                continue
            x, y = layout.route[j, i, 0], layout.route[j, i, 1]
            tx, ty, tz = tangent[at], tangent[at + width], tangent[at + 2 * width]
            # P = 1 - t t' on the tangent's derivatives (0, 0, y), (0, 0, -x), (-y, x, 0) by u, and the axes by v
            pz, spun = w * (1.0 - tz * tz), x * ty - y * tx
            uz = -w * spun * tz
            b00 += y * y * pz
            b10 -= x * y * pz
            b11 += x * x * pz
            b20 += y * uz
            b21 -= x * uz
            b22 += w * (x * x + y * y - spun * spun)
            b50 += y * pz
            b51 -= x * pz
            b52 += uz
            b55 += pz
            if sheared:
                b30 -= w * y * tx * tz
                b31 += w * x * tx * tz
                b32 -= w * (y + spun * tx)
                b33 += w * (1.0 - tx * tx)
                b40 -= w * y * ty * tz
                b41 += w * x * ty * tz
                b42 += w * (x - spun * ty)
                b43 -= w * tx * ty
                b44 += w * (1.0 - ty * ty)
                b53 -= w * tx * tz
                b54 -= w * ty * tz
        block[0, 0], block[0, 1], block[0, 2], block[0, 3], block[0, 4], block[0, 5] = b00, b10, b20, b30, b40, b50
        block[1, 0], block[1, 1], block[1, 2], block[1, 3], block[1, 4], block[1, 5] = b10, b11, b21, b31, b41, b51
        block[2, 0], block[2, 1], block[2, 2], block[2, 3], block[2, 4], block[2, 5] = b20, b21, b22, b32, b42, b52
        block[3, 0], block[3, 1], block[3, 2], block[3, 3], block[3, 4], block[3, 5] = b30, b31, b32, b33, b43, b53
        block[4, 0], block[4, 1], block[4, 2], block[4, 3], block[4, 4], block[4, 5] = b40, b41, b42, b43, b44, b54
        block[5, 0], block[5, 1], block[5, 2], block[5, 3], block[5, 4], block[5, 5] = b50, b51, b52, b53, b54, b55
        seen = -1
        for a in range(first, last):
            ca, value = layout.component[a], layout.tendon_at[j, a]
            if ca != seen:  # modes of a component follow each other
                seen = ca
                for b in range(first, last):
                    spread[b] = layout.tendon_at[j, b] * block[ca, layout.component[b]]
            for b in range(first, last):
                out[a, b] += value * spread[b]
