"""Path lengths of the tendons for given strains, with first and second derivatives: kinematics and actuation in one.

A tendon's displacement is the shortening of its path; by virtual work its gradient is the tendon's generalised force.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import kernel
from tendond.model.strain.layout import Layout

Array = NDArray[np.float64]


class Paths(NamedTuple):
    """Displacements of the tendons [m], shape (m,), and their gradient by the modes, shape (m, n)."""

    displacement: Array
    gradient: Array


def empty_paths(layout: Layout) -> Paths:
    """Return arrays for the tendons of this robot."""
    return Paths(np.zeros(len(layout.straight)), np.zeros((len(layout.straight), len(layout.component))))


@kernel
def find_paths(layout, q, paths):  # type: ignore[no-untyped-def]
    """Write displacements and gradients for the strains q, shape (n,)."""
    points, n = layout.tendon_at.shape
    tendons = len(layout.straight)
    strain, pull = np.empty(6), np.empty(6)
    for i in range(tendons):
        paths.displacement[i] = layout.straight[i]
        paths.gradient[i, :] = 0.0
    for j in range(points):
        for c in range(6):
            strain[c] = layout.tendon_strain[j, c]
        for d in range(n):
            strain[layout.component[d]] += layout.tendon_at[j, d] * q[d]
        for i in range(tendons):
            w = layout.weight[j, i]
            if w == 0.0:
                continue
            x, y = layout.route[j, i, 0], layout.route[j, i, 1]
            tx = strain[3] - strain[2] * y + layout.slope[j, i, 0]
            ty = strain[4] + strain[2] * x + layout.slope[j, i, 1]
            tz = strain[5] + strain[0] * y - strain[1] * x
            length = math.sqrt(tx * tx + ty * ty + tz * tz)
            paths.displacement[i] -= w * length
            f = w / length
            pull[0] = f * y * tz
            pull[1] = -f * x * tz
            pull[2] = f * (x * ty - y * tx)
            pull[3], pull[4], pull[5] = f * tx, f * ty, f * tz
            for d in range(n):
                paths.gradient[i, d] -= layout.tendon_at[j, d] * pull[layout.component[d]]


@kernel
def add_tendon_stiffness(layout, q, tension, factor, out):  # type: ignore[no-untyped-def]
    """Subtract `factor` times the sum of tension . d2(displacement)/dq dq from `out`, shape (n, n)."""
    points, n = layout.tendon_at.shape
    strain = np.empty(6)
    block = np.empty((6, 6))
    column = np.empty((6, 3))
    for j in range(points):
        any_tension = False
        for c in range(6):
            strain[c] = layout.tendon_strain[j, c]
        for d in range(n):
            strain[layout.component[d]] += layout.tendon_at[j, d] * q[d]
        block[:, :] = 0.0
        for i in range(len(tension)):
            w = layout.weight[j, i] * tension[i] * factor
            if w == 0.0:
                continue
            any_tension = True
            x, y = layout.route[j, i, 0], layout.route[j, i, 1]
            tx = strain[3] - strain[2] * y + layout.slope[j, i, 0]
            ty = strain[4] + strain[2] * x + layout.slope[j, i, 1]
            tz = strain[5] + strain[0] * y - strain[1] * x
            length = math.sqrt(tx * tx + ty * ty + tz * tz)
            tx, ty, tz = tx / length, ty / length, tz / length
            column[:, :] = 0.0
            column[0, 2], column[1, 2] = y, -x
            column[2, 0], column[2, 1] = -y, x
            column[3, 0] = column[4, 1] = column[5, 2] = 1.0
            for a in range(6):
                along = column[a, 0] * tx + column[a, 1] * ty + column[a, 2] * tz
                for b in range(a + 1):
                    other = column[b, 0] * tx + column[b, 1] * ty + column[b, 2] * tz
                    both = column[a, 0] * column[b, 0] + column[a, 1] * column[b, 1] + column[a, 2] * column[b, 2]
                    block[a, b] += w / length * (both - along * other)
        if not any_tension:
            continue
        for a in range(n):
            if layout.tendon_at[j, a] == 0.0:
                continue
            for b in range(n):
                ca, cb = layout.component[a], layout.component[b]
                value = block[ca, cb] if ca >= cb else block[cb, ca]
                out[a, b] += layout.tendon_at[j, a] * layout.tendon_at[j, b] * value
