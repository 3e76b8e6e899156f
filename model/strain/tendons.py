"""Path lengths of the tendons for given strains, with first and second derivatives: kinematics and actuation in one.

A tendon's displacement is the shortening of its path; by virtual work its gradient is the tendon's generalised force.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, kernel
from tendond.model.strain.layout import Layout

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class Paths(NamedTuple):
    """Displacements of the tendons, and what they follow from.

    Attributes:
        displacement: [m], shape (m,). gradient: by the modes, shape (m, n).
        first, last: modes that the strain at a tendon point has, as a range, shape (Q,).
        strain: at a point, shape (6,). pull: of each tendon on it, shape (6, m). block: stiffness by strains, (6, 6).
    """

    displacement: Array
    gradient: Array
    first: Index
    last: Index
    strain: Array
    pull: Array
    block: Array


def empty_paths(layout: Layout) -> Paths:
    """Return arrays for the tendons of this robot."""
    m, n = len(layout.straight), len(layout.component)
    used = layout.tendon_at != 0.0
    first = np.argmax(used, axis=1).astype(np.int64)
    last = (n - np.argmax(used[:, ::-1], axis=1)).astype(np.int64)
    return Paths(np.zeros(m), np.zeros((m, n)), first, last, np.zeros(6), np.zeros((6, m)), np.zeros((6, 6)))


@inlined
def _find_strain(layout: Layout, q: Array, j: int, paths: Paths) -> None:
    """Write the strain at the tendon point j."""
    for c in range(6):
        paths.strain[c] = layout.tendon_strain[j, c]
    for d in range(paths.first[j], paths.last[j]):
        paths.strain[layout.component[d]] += layout.tendon_at[j, d] * q[d]


@kernel
def find_paths(layout: Layout, q: Array, paths: Paths) -> None:
    """Write displacements and gradients for the strains q, shape (n,)."""
    n, tendons = len(q), len(layout.straight)
    strain, pull = paths.strain, paths.pull
    for i in range(tendons):
        paths.displacement[i] = layout.straight[i]
        for d in range(n):
            paths.gradient[i, d] = 0.0
    for j in range(len(paths.first)):
        _find_strain(layout, q, j, paths)
        u0, u1, u2, v0, v1, v2 = strain[0], strain[1], strain[2], strain[3], strain[4], strain[5]
        for i in range(tendons):
            x, y = layout.route[j, i, 0], layout.route[j, i, 1]
            tx = v0 - u2 * y + layout.slope[j, i, 0]
            ty = v1 + u2 * x + layout.slope[j, i, 1]
            tz = v2 + u0 * y - u1 * x
            length = math.sqrt(tx * tx + ty * ty + tz * tz)
            w = layout.weight[j, i]
            paths.displacement[i] -= w * length
            f = w / length
            pull[0, i] = f * y * tz
            pull[1, i] = -f * x * tz
            pull[2, i] = f * (x * ty - y * tx)
            pull[3, i], pull[4, i], pull[5, i] = f * tx, f * ty, f * tz
        for i in range(tendons):
            if layout.weight[j, i] != 0.0:
                for d in range(paths.first[j], paths.last[j]):
                    paths.gradient[i, d] -= layout.tendon_at[j, d] * pull[layout.component[d], i]


@kernel
def add_tendon_stiffness(layout: Layout, q: Array, tension: Array, factor: float, paths: Paths, out: Array) -> None:
    """Subtract `factor` times the sum of tension . d2(displacement)/dq dq from `out`, shape (n, n)."""
    tendons = len(tension)
    strain, block = paths.strain, paths.block
    for j in range(len(paths.first)):
        any_tension = False
        for i in range(tendons):
            any_tension |= layout.weight[j, i] * tension[i] != 0.0
        if not any_tension:
            continue
        _find_strain(layout, q, j, paths)
        u0, u1, u2, v0, v1, v2 = strain[0], strain[1], strain[2], strain[3], strain[4], strain[5]
        for a in range(6):
            for b in range(a + 1):
                block[a, b] = 0.0
        for i in range(tendons):
            w = layout.weight[j, i] * tension[i] * factor
            if w == 0.0:
                continue
            x, y = layout.route[j, i, 0], layout.route[j, i, 1]
            tx = v0 - u2 * y + layout.slope[j, i, 0]
            ty = v1 + u2 * x + layout.slope[j, i, 1]
            tz = v2 + u0 * y - u1 * x
            length = math.sqrt(tx * tx + ty * ty + tz * tz)
            tx, ty, tz = tx / length, ty / length, tz / length
            w /= length
            # P = 1 - t t' on the tangent's derivatives (0, 0, y), (0, 0, -x), (-y, x, 0) by u, and the axes by v
            pz, spun = 1.0 - tz * tz, x * ty - y * tx
            ux, uy = -y - spun * tx, x - spun * ty  # P (-y, x, 0), and its z component below
            uz = -spun * tz
            block[0, 0] += w * y * y * pz
            block[1, 0] -= w * x * y * pz
            block[1, 1] += w * x * x * pz
            block[2, 0] += w * y * uz
            block[2, 1] -= w * x * uz
            block[2, 2] += w * (x * uy - y * ux)
            block[3, 0] -= w * y * tx * tz
            block[3, 1] += w * x * tx * tz
            block[3, 2] += w * ux
            block[3, 3] += w * (1.0 - tx * tx)
            block[4, 0] -= w * y * ty * tz
            block[4, 1] += w * x * ty * tz
            block[4, 2] += w * uy
            block[4, 3] -= w * tx * ty
            block[4, 4] += w * (1.0 - ty * ty)
            block[5, 0] += w * y * pz
            block[5, 1] -= w * x * pz
            block[5, 2] += w * uz
            block[5, 3] -= w * tx * tz
            block[5, 4] -= w * ty * tz
            block[5, 5] += w * pz
        for a in range(6):
            for b in range(a):
                block[b, a] = block[a, b]
        for a in range(paths.first[j], paths.last[j]):
            ca, value = layout.component[a], layout.tendon_at[j, a]
            for b in range(paths.first[j], paths.last[j]):
                out[a, b] += value * layout.tendon_at[j, b] * block[ca, layout.component[b]]
