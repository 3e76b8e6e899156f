"""Derivative of the nodes' rotation rates about their own axes by the strains."""

from typing import Any

import numpy as np

from tendond.model.numerics.compile import inlined, kernel
from tendond.model.numerics.vectors import Vector, add, cross, dot, rotate, scale
from tendond.model.strain.derivatives.twists import (
    components,
    direction,
    polynomial,
    rotation_at,
    strain,
)
from tendond.model.strain.kinematics import COMMUTATOR, Shape
from tendond.model.strain.layout import Layout


@inlined
def _left(f: Vector, b: float, c: float, a: Vector) -> Vector:
    """Return the left Jacobian of the rotation f, of coefficients b and c, times a."""
    fa = cross(f, a)
    value: Vector = add(a, add(scale(b, fa), scale(c, cross(f, fa))))
    return value


@kernel
def find_spins(layout: Layout, q: Any, w: Any, shape: Shape, turn: Any, out: Any) -> None:
    """Write the derivative by q of each node's rotation rate about its own axis at fixed rates w, shape (K + 1, n).

    `turn` is room for the derivative of the nodes' rotation rates, shape (3, n).
    """
    n = len(q)
    still = np.zeros((len(layout.step), 6))
    own = np.empty((2, 3, 3))
    rate = (0.0, 0.0, 0.0)
    turn[:, :] = 0.0
    for k in range(len(layout.step)):
        first, last, h = layout.first[k], layout.last[k], layout.step[k]
        one, _ = strain(layout, q, k, layout.at1, layout.strain1)
        two, _ = strain(layout, q, k, layout.at2, layout.strain2)
        moved1, _ = strain(layout, w, k, layout.at1, still)
        moved2, _ = strain(layout, w, k, layout.at2, still)
        half, magnus = 0.5 * h, COMMUTATOR * h * h
        f = add(scale(half, add(one, two)), scale(magnus, cross(one, two)))
        x = dot(f, f)
        c1, c2, c3, c4, _, _, _, _ = polynomial(x)
        b, c = c1 - x * c3, c2 - x * c4
        a = add(scale(half, add(moved1, moved2)), scale(magnus, add(cross(moved1, two), cross(one, moved2))))
        fa = cross(f, a)
        squared = add(scale(-2.0 * c3, fa), scale(-2.0 * c4, cross(f, fa)))
        r = rotation_at(shape, k)
        there = components(layout, k)
        for axis in range(3):
            if not there & (1 << axis):
                continue
            e, _ = direction(axis)
            for point in range(2):
                turned = cross(e, two) if point == 0 else cross(one, e)
                both = cross(e, moved2) if point == 0 else cross(moved1, e)
                by = add(scale(half, e), scale(magnus, turned))
                ba = cross(by, a)
                y = add(scale(b, ba), scale(c, add(cross(by, fa), cross(f, ba))))
                y = add(add(y, scale(dot(f, by), squared)), _left(f, b, c, scale(magnus, both)))
                own[point, axis, 0], own[point, axis, 1], own[point, axis, 2] = rotate(r, y)
        part = rotate(r, _left(f, b, c, a))
        for d in range(last):
            t0, t1, t2 = shape.twist[k, 0, d], shape.twist[k, 1, d], shape.twist[k, 2, d]
            turn[0, d] += t1 * part[2] - t2 * part[1]
            turn[1, d] += t2 * part[0] - t0 * part[2]
            turn[2, d] += t0 * part[1] - t1 * part[0]
        for d in range(first, last):
            axis = layout.component[d]
            if axis < 3:
                for i in range(3):
                    turn[i, d] += layout.at1[k, d] * own[0, axis, i] + layout.at2[k, d] * own[1, axis, i]
        rate = add(rate, part)
        z = (shape.rotation[k + 1, 2], shape.rotation[k + 1, 5], shape.rotation[k + 1, 8])
        across = cross(z, rate)
        for d in range(last):
            out[k + 1, d] = (
                shape.twist[k + 1, 0, d] * across[0] + shape.twist[k + 1, 1, d] * across[1]
                + shape.twist[k + 1, 2, d] * across[2] + z[0] * turn[0, d] + z[1] * turn[1, d] + z[2] * turn[2, d]
            )  # fmt: skip
        for d in range(last, n):
            out[k + 1, d] = 0.0
