"""The derivative of the balance of a step by the strains after it, for Newton's method."""

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.products import add_products, padded
from tendond.model.numerics.vectors import Vector
from tendond.model.strain.kinematics import Shape, curvature_of_points
from tendond.model.strain.layout import Layout
from tendond.model.strain.stepping.scratch import Loads, Scratch
from tendond.model.strain.tendon_stiffness import add_tendon_stiffness

Array = NDArray[np.float64]


@inlined
def _moved(one: Shape, two: Shape, j: int) -> Vector:
    """Return how far a mass point is from one shape to the other [m]."""
    a, b = one.point, two.point
    return b[j, 0] - a[j, 0], b[j, 1] - a[j, 1], b[j, 2] - a[j, 2]


@lean
def find_matrix(layout: Layout, loads: Loads, q1: Array, h: float, work: Scratch) -> None:
    """Write the derivative of the residual by q1 to `work.matrix`, after `find_residual` there."""
    n, width = len(q1), padded(len(q1))
    m, row, change, pull = work.hessian, work.row, work.change, work.pull
    one, two = work.before, work.after
    for a in range(n):
        row[a] = 0.0  # derivative of what the balance lacks
        for b in range(n):
            m[a, b] = 0.0
    curvature_of_points(layout, two, work.force, work.left, work.right, work.total, m)
    if len(work.taut) > 0:
        add_tendon_stiffness(work.taut, work.paths_after, m)
    left, right, total = work.left, work.right, work.total
    left[:], right[:], total[:] = 0.0, 0.0, 0.0
    r = first = j = 0
    for k in range(1, len(layout.polar)):
        last = layout.last[k - 1]
        while j < len(layout.mass) and layout.place[j] == k:
            factor = 2.0 * layout.mass[j] / (h * h)
            x, y, z = _moved(one, two, j)
            xx = yy = zz = factor
            xy = yz = zx = 0.0
            for c in range(3):
                if layout.drag[j, c] != 0.0:
                    rx = 0.5 * (one.rotation[k, c] + two.rotation[k, c])
                    ry = 0.5 * (one.rotation[k, 3 + c] + two.rotation[k, 3 + c])
                    rz = 0.5 * (one.rotation[k, 6 + c] + two.rotation[k, 6 + c])
                    slope = 2.0 * layout.drag[j, c] * abs(rx * x + ry * y + rz * z) / (h * h)
                    xx += slope * rx * rx
                    yy += slope * ry * ry
                    zz += slope * rz * rz
                    xy += slope * rx * ry
                    yz += slope * ry * rz
                    zx += slope * rz * rx
            fx = work.force[j, 0] + xx * x + xy * y + zx * z
            fy = work.force[j, 1] + xy * x + yy * y + yz * z
            fz = work.force[j, 2] + zx * x + yz * y + zz * z
            p0, p1, p2 = r * width, (r + 1) * width, (r + 2) * width
            for b in range(last):
                jx, jy, jz = two.jacobian[j, 0, b], two.jacobian[j, 1, b], two.jacobian[j, 2, b]
                right[p0 + b], right[p1 + b], right[p2 + b] = jx, jy, jz
                row[b] += fx * jx + fy * jy + fz * jz
                jx = 0.5 * (jx + one.jacobian[j, 0, b])
                jy = 0.5 * (jy + one.jacobian[j, 1, b])
                jz = 0.5 * (jz + one.jacobian[j, 2, b])
                left[p0 + b] = xx * jx + xy * jy + zx * jz
                left[p1 + b] = xy * jx + yy * jy + yz * jz
                left[p2 + b] = zx * jx + yz * jy + zz * jz
            r += 3
            j += 1
        if k + 1 == len(layout.polar) or layout.last[k] != last:
            add_products(left, right, width, (first, r), (0, last), (0, last), total)
            first = r
    first = r
    for i in range(len(work.taut)):
        tension, slope = work.taut[i], work.slack[i]
        if tension != 0.0:
            shortened = work.paths_after.displacement[i] - work.paths_before.displacement[i]
            force = slope * shortened + tension
            for b in range(n):
                row[b] -= force * work.paths_after.gradient[i, b]
        if slope != 0.0:
            for b in range(n):
                right[r * width + b] = work.paths_after.gradient[i, b]
                left[r * width + b] = -0.5 * slope * (
                    work.paths_before.gradient[i, b] + work.paths_after.gradient[i, b]
                )  # fmt: skip
            r += 1
    if r > first:
        add_products(left, right, width, (first, r), (0, n), (0, n), total)
    share, norm = work.unit[1], work.unit[2]
    for b in range(n):
        row[b] -= pull[b] + 2.0 * share * layout.stiffness[b, b] * change[b]
    for a in range(n):
        for b in range(n):
            m[a, b] = 0.5 * m[a, b] + total[a * width + b]
            row[b] -= change[a] * m[a, b]
    total[:] = 0.0
    r = first = 0
    for k in range(1, len(layout.polar)):
        last, inertia = layout.last[k - 1], 0.5 * layout.polar[k] / (h * h)
        if inertia != 0.0:
            for a in range(last):
                both = one.spin[k, a] + two.spin[k, a]
                left[r * width + a], right[r * width + a] = inertia * both, both
            for a in range(last, width):
                left[r * width + a] = right[r * width + a] = 0.0
            r += 1
        if k + 1 == len(layout.polar) or layout.last[k] != last:
            add_products(left, right, width, (first, r), (0, last), (0, last), total)
            first = r
    for a in range(n):
        along = layout.stiffness[a, a] * change[a] / norm
        for b in range(n):
            work.matrix[a * width + b] = m[a, b] + total[a * width + b] + work.elastic[a, b] + along * row[b]
        work.matrix[a * width + a] += share * layout.stiffness[a, a]
