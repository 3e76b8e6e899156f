"""Second derivatives of a shape by its strains: exact for the discrete shape, as its Jacobians are.

With the spatial twist X_a of a node by the mode a, and the part Y_a of it that an interval adds, [,] the Lie bracket,

    dY_a/dq_b = [X_b, Y_a] + Ad_g d/dq_b (J(psi) dpsi/dq_a),

X_b of the interval's base, g its pose, psi its Magnus twist and J the left Jacobian. For twists in space J is a
polynomial of degree four of ad(psi), with coefficients of the squared angle alone (T. D. Barfoot, State Estimation for
Robotics, 2017, equation 7.86), so that its derivative takes a few brackets.
"""

from typing import Any

import numpy as np

from tendond.model.numerics.compile import kernel
from tendond.model.numerics.vectors import add, cross, dot, rotate_back, scale
from tendond.model.strain.derivatives.twists import (
    bracket,
    components,
    direction,
    magnus,
    magnus_change,
    pair,
    plus,
    polynomial,
    rotation_at,
    strain,
    times,
    transposed,
    twist_at,
)
from tendond.model.strain.kinematics import COMMUTATOR, Shape
from tendond.model.strain.layout import Layout


@kernel
def add_curvature(layout: Layout, q: Any, shape: Shape, force: Any, moment: Any, spin: Any, out: Any) -> None:
    """Add sum force . d2x_a/dq_b + sum moment . d(turn_a)/dq_b + sum spin d(own turn_a)/dq_b to out[a, b].

    `force` acts on the mass points, shape (P, 3), `moment` on the nodes, shape (K + 1, 3), dead, world frame; `spin`
    about each node's own axis, shape (K + 1,). Only the moments' part is not symmetric.
    """
    alpha = np.empty((2, 6, 6))  # dpsi by the strain at each Gauss point
    dual = np.empty((2, 6, 6))  # B(beta, alpha) = beta . dual(alpha) + 2 (f . beta) z . alpha
    block = np.empty((2, 6, 2, 6))
    f = (0.0, 0.0, 0.0)
    dead = (0.0, 0.0, 0.0)
    own = (0.0, 0.0, 0.0)
    lever = (0.0, 0.0, 0.0)  # sum of x x force
    sum_of = np.zeros(9)  # sum of x force', row by row
    j = len(layout.mass) - 1
    for k in range(len(layout.step) - 1, -1, -1):
        first, last, h = layout.first[k], layout.last[k], layout.step[k]
        while j >= 0 and layout.place[j] == k + 1:
            x, pull = (shape.point[j, 0], shape.point[j, 1], shape.point[j, 2]), (force[j, 0], force[j, 1], force[j, 2])
            for a in range(3):
                for b in range(3):
                    sum_of[3 * a + b] += x[a] * pull[b]
            f, lever = add(f, pull), add(lever, cross(x, pull))
            j -= 1
        dead = add(dead, (moment[k + 1, 0], moment[k + 1, 1], moment[k + 1, 2]))
        axis = (shape.rotation[k + 1, 2], shape.rotation[k + 1, 5], shape.rotation[k + 1, 8])
        own = add(own, scale(spin[k + 1], axis))
        trace = sum_of[0] + sum_of[4] + sum_of[8]
        turning = own[0] != 0.0 or own[1] != 0.0 or own[2] != 0.0
        loaded = dead[0] != 0.0 or dead[1] != 0.0 or dead[2] != 0.0
        for d in range(first, last):
            t = twist_at(shape.part, k, d)
            a = t[0]
            x = (
                sum_of[0] * a[0] + sum_of[1] * a[1] + sum_of[2] * a[2] - trace * a[0],
                sum_of[3] * a[0] + sum_of[4] * a[1] + sum_of[5] * a[2] - trace * a[1],
                sum_of[6] * a[0] + sum_of[7] * a[1] + sum_of[8] * a[2] - trace * a[2],
            )
            x = add(x, cross(t[1], f))
            for e in range(last):
                turn = twist_at(shape.twist, k, e)[0]
                value = dot(turn, x)
                if e >= first:
                    value += 0.5 * dot(twist_at(shape.part, k, e)[0], x)
                out[d, e] += value
                out[e, d] += value
                if turning or loaded:
                    across = cross(turn, a)
                    if e >= first:
                        across = add(across, scale(0.5, cross(twist_at(shape.part, k, e)[0], a)))
                    out[e, d] += dot(own, across)
                    out[d, e] += dot(dead, across)
        wrench = add(lever, add(dead, own)), f
        if wrench == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)):
            continue
        # the symmetric part of an interval's own second derivative
        r, p = rotation_at(shape, k), (shape.position[k, 0], shape.position[k, 1], shape.position[k, 2])
        l0 = rotate_back(r, add(wrench[0], cross(wrench[1], p))), rotate_back(r, wrench[1])
        one, two = strain(layout, q, k, layout.at1, layout.strain1), strain(layout, q, k, layout.at2, layout.strain2)
        psi = magnus(h, one, two)
        c1, c2, c3, c4, d1, d2, d3, d4 = polynomial(dot(psi[0], psi[0]))
        l1 = transposed(psi, l0)
        l2 = transposed(psi, l1)
        l3 = transposed(psi, l2)
        l4 = transposed(psi, l3)
        whole = plus(l0, plus(plus(times(c1, l1), times(c2, l2)), plus(times(c3, l3), times(c4, l4))))
        z = plus(plus(times(d1, l1), times(d2, l2)), plus(times(d3, l3), times(d4, l4)))
        y0 = plus(plus(times(c1, l0), times(c2, l1)), plus(times(c3, l2), times(c4, l3)))
        y1 = plus(plus(times(c2, l0), times(c3, l1)), times(c4, l2))
        y2 = plus(times(c3, l0), times(c4, l1))
        y3 = times(c4, l0)
        there = components(layout, k)
        for c in range(6):
            if not there & (1 << c):
                continue
            for point in range(2):
                t = magnus_change(h, point, one, two, direction(c))
                along = 2.0 * pair(z, t)
                for i in range(3):
                    alpha[point, c, i], alpha[point, c, 3 + i] = t[0][i], t[1][i]
                    dual[point, c, i] = along * psi[0][i]
                    dual[point, c, 3 + i] = 0.0
                for step in range(4):
                    y = y0 if step == 0 else y1 if step == 1 else y2 if step == 2 else y3
                    u, v = add(cross(t[0], y[0]), cross(t[1], y[1])), cross(t[0], y[1])
                    for i in range(3):
                        dual[point, c, i] += u[i]
                        dual[point, c, 3 + i] += v[i]
                    t = bracket(psi, t)
        for point in range(2):
            for c in range(6):
                if not there & (1 << c):
                    continue
                for other in range(2):
                    for e in range(6):
                        if not there & (1 << e):
                            continue
                        value = 0.0
                        for i in range(6):
                            value += alpha[other, e, i] * dual[point, c, i] + alpha[point, c, i] * dual[other, e, i]
                        if point != other:
                            one_by, two_by = (c, e) if point == 0 else (e, c)
                            both = bracket(direction(one_by), direction(two_by))
                            value += 2.0 * COMMUTATOR * h * h * pair(whole, both)
                        block[point, c, other, e] = 0.5 * value
        for d in range(first, last):
            c = layout.component[d]
            for e in range(first, last):
                b = layout.component[e]
                out[d, e] += layout.at1[k, d] * (
                    layout.at1[k, e] * block[0, c, 0, b] + layout.at2[k, e] * block[0, c, 1, b]
                ) + layout.at2[k, d] * (layout.at1[k, e] * block[1, c, 0, b] + layout.at2[k, e] * block[1, c, 1, b])
