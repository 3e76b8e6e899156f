"""Motion of a shape for given rates of its strains, and its exact derivative by the strains.

With the spatial twist X_a of a node by the mode a, and the part Y_a of it that an interval adds, [,] the Lie bracket,

    dY_a/dq_b = [X_b, Y_a] + Ad_g d/dq_b (J(psi) dpsi/dq_a),

X_b of the interval's base, g its pose, psi its Magnus twist and J the left Jacobian. For twists in space J is a
polynomial of degree four of ad(psi), with coefficients of the squared angle alone (T. D. Barfoot, State Estimation for
Robotics, 2017, equation 7.86), so that its derivative takes a few brackets.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import kernel
from tendond.model.numerics.parked import park
from tendond.model.numerics.vectors import add, cross, dot, rotate
from tendond.model.strain.derivatives.twists import (
    bracket,
    components,
    direction,
    jacobian_at,
    magnus,
    magnus_change,
    plus,
    polynomial,
    rotation_at,
    strain,
    times,
    twist_at,
)
from tendond.model.strain.kinematics import COMMUTATOR, Shape
from tendond.model.strain.layout import Layout

Array = NDArray[np.float64]


class Rates(NamedTuple):
    """Motion of a shape for given rates of its strains w, and its derivative by the strains; world frame.

    Attributes:
        node: spatial twist X w of each node, shape (K + 1, 6); slope: its derivative, shape (K + 1, 6, n).
        point: derivative of each mass point's velocity J w [m], shape (P, 3, n).
        spin: derivative of each node's rotation rate about its own axis, shape (K + 1, n).
    """

    node: Array
    slope: Array
    point: Array
    spin: Array


def empty_rates(layout: Layout) -> Rates:
    """Return arrays for the rates of this robot."""
    nodes, n = len(layout.polar), len(layout.component)
    rates = Rates(
        np.zeros((nodes, 6)), np.zeros((nodes, 6, n)), np.zeros((len(layout.mass), 3, n)), np.zeros((nodes, n))
    )
    return park(rates)


@kernel
def find_rates(layout: Layout, q: Any, w: Any, shape: Shape, rates: Rates) -> None:
    """Write the motion of the shape at q for the rates w, both shape (n,), and its derivative by q at fixed w."""
    n = len(q)
    still = np.zeros((len(layout.step), 6))
    own = np.empty((2, 6, 6))
    rates.node[0, :] = 0.0
    rates.slope[0, :, :] = 0.0
    for k in range(len(layout.step)):
        first, last, h = layout.first[k], layout.last[k], layout.step[k]
        one, two = strain(layout, q, k, layout.at1, layout.strain1), strain(layout, q, k, layout.at2, layout.strain2)
        moved1, moved2 = strain(layout, w, k, layout.at1, still), strain(layout, w, k, layout.at2, still)
        psi = magnus(h, one, two)
        c1, c2, c3, c4, d1, d2, d3, d4 = polynomial(dot(psi[0], psi[0]))
        t0 = plus(magnus_change(h, 0, one, two, moved1), magnus_change(h, 1, one, two, moved2))
        t1 = bracket(psi, t0)
        t2 = bracket(psi, t1)
        t3 = bracket(psi, t2)
        t4 = bracket(psi, t3)
        part = plus(t0, plus(plus(times(c1, t1), times(c2, t2)), plus(times(c3, t3), times(c4, t4))))
        squared = plus(plus(times(d1, t1), times(d2, t2)), plus(times(d3, t3), times(d4, t4)))
        q0 = plus(plus(times(c1, t0), times(c2, t1)), plus(times(c3, t2), times(c4, t3)))
        q1 = plus(plus(times(c2, t0), times(c3, t1)), times(c4, t2))
        q2 = plus(times(c3, t0), times(c4, t1))
        q3 = times(c4, t0)
        r, p = rotation_at(shape, k), (shape.position[k, 0], shape.position[k, 1], shape.position[k, 2])
        there = components(layout, k)
        for c in range(6):
            if not there & (1 << c):
                continue
            e = direction(c)
            for point in range(2):
                by = magnus_change(h, point, one, two, e)
                x = bracket(by, q3)
                x = plus(bracket(by, q2), bracket(psi, x))
                x = plus(bracket(by, q1), bracket(psi, x))
                x = plus(bracket(by, q0), bracket(psi, x))
                x = plus(x, times(2.0 * dot(psi[0], by[0]), squared))
                both = bracket(e, moved2) if point == 0 else bracket(moved1, e)
                y0 = times(COMMUTATOR * h * h, both)
                y1 = bracket(psi, y0)
                y2 = bracket(psi, y1)
                y3 = bracket(psi, y2)
                y4 = bracket(psi, y3)
                x = plus(x, plus(y0, plus(plus(times(c1, y1), times(c2, y2)), plus(times(c3, y3), times(c4, y4)))))
                u, v = rotate(r, x[0]), rotate(r, x[1])
                v = add(v, cross(p, u))
                for i in range(3):
                    own[point, c, i], own[point, c, 3 + i] = u[i], v[i]
        u, v = rotate(r, part[0]), rotate(r, part[1])
        v = add(v, cross(p, u))
        for i in range(3):
            rates.node[k + 1, i] = rates.node[k, i] + u[i]
            rates.node[k + 1, 3 + i] = rates.node[k, 3 + i] + v[i]
        for d in range(last):
            turned = bracket(twist_at(shape.twist, k, d), (u, v))
            for i in range(3):
                rates.slope[k + 1, i, d] = rates.slope[k, i, d] + turned[0][i]
                rates.slope[k + 1, 3 + i, d] = rates.slope[k, 3 + i, d] + turned[1][i]
        for d in range(last, n):
            rates.slope[k + 1, :, d] = 0.0
        for d in range(first, last):
            c = layout.component[d]
            for i in range(6):
                rates.slope[k + 1, i, d] += layout.at1[k, d] * own[0, c, i] + layout.at2[k, d] * own[1, c, i]
        axis = (shape.rotation[k + 1, 2], shape.rotation[k + 1, 5], shape.rotation[k + 1, 8])
        moved = (rates.node[k + 1, 0], rates.node[k + 1, 1], rates.node[k + 1, 2])
        across = cross(axis, moved)
        for d in range(n):
            turn, slope = twist_at(shape.twist, k + 1, d)[0], twist_at(rates.slope, k + 1, d)[0]
            rates.spin[k + 1, d] = dot(turn, across) + dot(axis, slope)
    for j in range(len(layout.mass)):
        k = layout.place[j]
        x = (shape.point[j, 0], shape.point[j, 1], shape.point[j, 2])
        spin = (rates.node[k, 0], rates.node[k, 1], rates.node[k, 2])
        for d in range(n):
            slope = twist_at(rates.slope, k, d)
            value = add(add(cross(slope[0], x), slope[1]), cross(spin, jacobian_at(shape, j, d)))
            rates.point[j, 0, d], rates.point[j, 1, d], rates.point[j, 2, d] = value
