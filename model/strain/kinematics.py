"""Where a robot is for given strains, and how every point of it moves with them: one march from base to tip.

The strain is integrated over an interval by the fourth-order Magnus expansion on SE(3), whose derivative is exact for
it: the Jacobians are those of the discrete shape (A. Iserles, H. Z. Munthe-Kaas, S. P. Norsett, A. Zanna, "Lie-group
methods", Acta Numerica 9, 2000, section 5). Jacobians are kept as spatial twists, which add up along the backbone.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, kernel
from tendond.model.numerics.vectors import Vector, add, cross, rotate, scale
from tendond.model.strain.layout import Layout
from tendond.model.strain.se3 import exponential, product

Array = NDArray[np.float64]

COMMUTATOR = math.sqrt(3.0) / 12.0
"""Of the Magnus expansion with two Gauss points."""


class Shape(NamedTuple):
    """A robot's shape, and its Jacobians; world frame.

    Attributes:
        rotation: of each node, row by row, shape (K + 1, 9). position: [m], shape (K + 1, 3).
        twist: spatial twist of each node by each mode, shape (K + 1, n, 6); part: of each interval, shape (K, n, 6).
        point: mass points [m], shape (P, 3). jacobian: by the modes [m], shape (P, n, 3).
        spin: rotation about the own axis of each node by each mode, shape (K + 1, n).
    """

    rotation: Array
    position: Array
    twist: Array
    part: Array
    point: Array
    jacobian: Array
    spin: Array


def empty_shape(layout: Layout) -> Shape:
    """Return arrays for a shape of this robot."""
    intervals, n = layout.at1.shape
    points = len(layout.mass)
    return Shape(
        np.zeros((intervals + 1, 9)), np.zeros((intervals + 1, 3)), np.zeros((intervals + 1, n, 6)),
        np.zeros((intervals, n, 6)), np.zeros((points, 3)), np.zeros((points, n, 3)), np.zeros((intervals + 1, n)),
    )  # fmt: skip


@inlined
def _bracket(au: Vector, av: Vector, bu: Vector, bv: Vector) -> tuple[Vector, Vector]:
    """Lie bracket of two twists."""
    return cross(au, bu), add(cross(au, bv), cross(av, bu))


@inlined
def _unit(component: int) -> tuple[Vector, Vector]:
    u = (1.0 if component == 0 else 0.0, 1.0 if component == 1 else 0.0, 1.0 if component == 2 else 0.0)
    v = (1.0 if component == 3 else 0.0, 1.0 if component == 4 else 0.0, 1.0 if component == 5 else 0.0)
    return u, v


@kernel
def strain_at(layout, q, k, at, reference, out):  # type: ignore[no-untyped-def]
    """Write the strain of interval k where the modes have the values `at`, shape (6,)."""
    for c in range(6):
        out[c] = reference[k, c]
    for d in range(layout.first[k], layout.last[k]):
        out[layout.component[d]] += at[k, d] * q[d]


@kernel
def pose(layout, shape, k):  # type: ignore[no-untyped-def]
    """Return rotation and position of the node k as tuples."""
    r, p = shape.rotation[k], shape.position[k]
    return (r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]), (p[0], p[1], p[2])


@kernel
def find_shape(layout, q, shape):  # type: ignore[no-untyped-def]
    """Write the shape for the strains q, shape (n,), with all Jacobians."""
    n = len(q)
    one, two = np.empty(6), np.empty(6)
    moved = np.empty((2, 6, 6))
    for c in range(9):
        shape.rotation[0, c] = layout.base[c]
    shape.position[0, :] = layout.origin
    shape.twist[0, :, :] = 0.0
    shape.spin[0, :] = 0.0
    for k in range(len(layout.step)):
        strain_at(layout, q, k, layout.at1, layout.strain1, one)
        strain_at(layout, q, k, layout.at2, layout.strain2, two)
        h = layout.step[k]
        w = COMMUTATOR * h * h
        u1, v1 = (one[0], one[1], one[2]), (one[3], one[4], one[5])
        u2, v2 = (two[0], two[1], two[2]), (two[3], two[4], two[5])
        bu, bv = _bracket(u1, v1, u2, v2)
        f = add(scale(0.5 * h, add(u1, u2)), scale(w, bu))
        r = add(scale(0.5 * h, add(v1, v2)), scale(w, bv))
        turn, jacobian, coupling = exponential(f, r)
        before, place = pose(layout, shape, k)
        after = product(before, turn)
        step = rotate(before, rotate(jacobian, r))
        for c in range(9):
            shape.rotation[k + 1, c] = after[c]
        for c in range(3):
            shape.position[k + 1, c] = place[c] + step[c]
        rj, rq = product(before, jacobian), product(before, coupling)
        done = 0
        for d in range(layout.first[k], layout.last[k]):  # twist of each component at both Gauss points
            c = layout.component[d]
            if done & (1 << c):
                continue
            done |= 1 << c
            eu, ev = _unit(c)
            for point in range(2):
                cu, cv = _bracket(eu, ev, u2, v2) if point == 0 else _bracket(u1, v1, eu, ev)
                au = add(scale(0.5 * h, eu), scale(w, cu))
                av = add(scale(0.5 * h, ev), scale(w, cv))
                ou = rotate(rj, au)
                ov = add(add(rotate(rq, au), rotate(rj, av)), cross(place, ou))
                for i in range(3):
                    moved[point, c, i] = ou[i]
                    moved[point, c, 3 + i] = ov[i]
        for d in range(n):
            for i in range(6):
                shape.twist[k + 1, d, i] = shape.twist[k, d, i]
        for d in range(layout.first[k], layout.last[k]):
            c = layout.component[d]
            for i in range(6):
                part = layout.at1[k, d] * moved[0, c, i] + layout.at2[k, d] * moved[1, c, i]
                shape.part[k, d, i] = part
                shape.twist[k + 1, d, i] += part
        for d in range(n):
            t = shape.twist[k + 1, d]
            shape.spin[k + 1, d] = after[2] * t[0] + after[5] * t[1] + after[8] * t[2]
    for j in range(len(layout.mass)):
        k = layout.place[j]
        rotation, place = pose(layout, shape, k)
        x = add(place, rotate(rotation, (layout.arm[j, 0], layout.arm[j, 1], layout.arm[j, 2])))
        for i in range(3):
            shape.point[j, i] = x[i]
        for d in range(n):
            t = shape.twist[k, d]
            shape.jacobian[j, d, 0] = t[1] * x[2] - t[2] * x[1] + t[3]
            shape.jacobian[j, d, 1] = t[2] * x[0] - t[0] * x[2] + t[4]
            shape.jacobian[j, d, 2] = t[0] * x[1] - t[1] * x[0] + t[5]


@kernel
def curvature_of_points(layout, shape, force, out):  # type: ignore[no-untyped-def]
    """Add the sum over the mass points of force . d2x/dq dq, shape (n, n); forces are dead, world frame, shape (P, 3).

    A point that a distal strain moves by J is turned by every proximal strain's rotation: d2x = w x J. In their own
    interval both count by half, which is exact as the interval goes to 0.
    """
    intervals = len(layout.step)
    fx = fy = fz = 0.0
    q = np.zeros(9)  # sum of x F' over the points beyond, row by row
    j = len(layout.mass) - 1
    lever = np.empty(3)
    for k in range(intervals - 1, -1, -1):
        while j >= 0 and layout.place[j] == k + 1:
            for a in range(3):
                for b in range(3):
                    q[3 * a + b] += shape.point[j, a] * force[j, b]
            fx += force[j, 0]
            fy += force[j, 1]
            fz += force[j, 2]
            j -= 1
        trace = q[0] + q[4] + q[8]
        for d in range(layout.first[k], layout.last[k]):
            t = shape.part[k, d]
            lever[0] = q[0] * t[0] + q[1] * t[1] + q[2] * t[2] - trace * t[0] + t[4] * fz - t[5] * fy
            lever[1] = q[3] * t[0] + q[4] * t[1] + q[5] * t[2] - trace * t[1] + t[5] * fx - t[3] * fz
            lever[2] = q[6] * t[0] + q[7] * t[1] + q[8] * t[2] - trace * t[2] + t[3] * fy - t[4] * fx
            for e in range(layout.last[k]):
                s = shape.twist[k, e]
                value = s[0] * lever[0] + s[1] * lever[1] + s[2] * lever[2]
                if e >= layout.first[k]:
                    o = shape.part[k, e]
                    value += 0.5 * (o[0] * lever[0] + o[1] * lever[1] + o[2] * lever[2])
                out[d, e] += value
                out[e, d] += value
