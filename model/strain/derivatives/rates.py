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

from tendond.model.numerics.compile import lean
from tendond.model.numerics.parked import park
from tendond.model.numerics.products import BLOCK, HALF
from tendond.model.numerics.simd import simd_load, simd_store
from tendond.model.numerics.vectors import add, cross, dot, rotate
from tendond.model.strain.directions import DIRECTIONS, vector_by_modes
from tendond.model.strain.kinematics import Shape, aligned, rotation_of, strain_of
from tendond.model.strain.layout import Layout
from tendond.model.strain.second_derivatives.bends import Bends
from tendond.model.strain.twists import (
    COMMUTATOR,
    bracket,
    load_six,
    magnus,
    magnus_change,
    plus,
    polynomial,
    store_six,
    strain_rate,
    times,
)

Array = NDArray[np.float64]


class Rates(NamedTuple):
    """Motion of a shape for given rates of its strains w, and its derivative by the strains; world frame.

    Attributes:
        node: spatial twist X w of each node, shape (K + 1, 6); slope: its derivative, shape (K + 1, 6, N).
        point: derivative of each mass point's velocity J w [m], shape (P, 3, N).
        spin: derivative of each node's rotation rate about its own axis, shape (K + 1, N); N as in `Shape`.
        slopes, points, spins: the same numbers in a row.
    """

    node: Array
    slope: Array
    point: Array
    spin: Array
    slopes: Array
    points: Array
    spins: Array


def empty_rates(layout: Layout) -> Rates:
    """Return arrays for the rates of this robot."""
    nodes, points, width = len(layout.polar), len(layout.mass), -(-len(layout.component) // HALF) * HALF
    slopes, moved, spins = aligned(nodes * 6 * width), aligned(points * 3 * width), aligned(nodes * width)
    rates = Rates(
        np.zeros((nodes, 6)), slopes.reshape(nodes, 6, width), moved.reshape(points, 3, width),
        spins.reshape(nodes, width), slopes, moved, spins,
    )  # fmt: skip
    return park(rates)


@lean
def find_rates(layout: Layout, w: Any, shape: Shape, room: Bends, rates: Rates) -> None:
    """Write the motion of a shape for the rates w, shape (n,), and its derivative by the strains at fixed w."""
    own, width = room.change, rates.spin.shape[1]
    for k in range(len(layout.step)):
        last, h = layout.last[k], layout.step[k]
        one, two = strain_of(shape, k, 0), strain_of(shape, k, 1)
        moved1, moved2 = strain_rate(layout, w, k, layout.at1), strain_rate(layout, w, k, layout.at2)
        psi = magnus(h, one, two)
        c1, c2, c3, c4, d1, d2, d3, d4 = polynomial(dot(psi[0], psi[0]))
        t0 = magnus_change(h, moved1, moved2, one, two)
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
        r, p = rotation_of(shape, k), (shape.position[k, 0], shape.position[k, 1], shape.position[k, 2])
        for group in range(room.directions.groups[k]):
            unit, at = room.directions.unit, room.directions.base[k] + group * HALF
            e1, e2 = load_six(unit, at, DIRECTIONS), load_six(unit, at + 6 * DIRECTIONS, DIRECTIONS)
            by = magnus_change(h, e1, e2, one, two)
            y = times(COMMUTATOR * h * h, plus(bracket(e1, moved2), bracket(moved1, e2)))
            x = plus(plus(bracket(by, q3), times(c3, y)), bracket(psi, times(c4, y)))
            x = plus(plus(bracket(by, q2), times(c2, y)), bracket(psi, x))
            x = plus(plus(bracket(by, q1), times(c1, y)), bracket(psi, x))
            x = plus(plus(bracket(by, q0), y), bracket(psi, x))
            x = plus(x, times(dot(psi[0], by[0]) * 2.0, squared))
            turned = rotate(r, x[0])
            store_six(own, group * HALF, DIRECTIONS, (turned, add(rotate(r, x[1]), cross(p, turned))))
        u, v = rotate(r, part[0]), rotate(r, part[1])
        v = add(v, cross(p, u))
        for i in range(3):
            rates.node[k + 1, i] = rates.node[k, i] + u[i]
            rates.node[k + 1, 3 + i] = rates.node[k, 3 + i] + v[i]
        axis = (shape.rotation[k + 1, 2], shape.rotation[k + 1, 5], shape.rotation[k + 1, 8])
        moved = (rates.node[k + 1, 0], rates.node[k + 1, 1], rates.node[k + 1, 2])
        across = cross(axis, moved)
        near, far = 6 * k * width, 6 * (k + 1) * width
        for b in range(0, last, HALF):
            turned = bracket(load_six(shape.twists, near + b, width), (u, v))
            slope = plus(load_six(rates.slopes, near + b, width), turned)
            if b >= room.directions.begin[k]:
                x = vector_by_modes(room.directions, k, own, 0, b), vector_by_modes(room.directions, k, own, 3, b)
                slope = plus(slope, x)
            store_six(rates.slopes, far + b, width, slope)
            turn = load_six(shape.twists, far + b, width)[0]
            simd_store(rates.spins, (k + 1) * width + b, dot(turn, across) + dot(axis, slope[0]))
    for j in range(len(layout.mass)):
        k = layout.place[j]
        x = (shape.point[j, 0], shape.point[j, 1], shape.point[j, 2])
        spin = (rates.node[k, 0], rates.node[k, 1], rates.node[k, 2])
        at = 3 * j * width
        for b in range(0, layout.last[k - 1], HALF):
            slope = load_six(rates.slopes, 6 * k * width + b, width)
            arm = (
                simd_load(shape.jacobians, at + b, BLOCK), simd_load(shape.jacobians, at + width + b, BLOCK),
                simd_load(shape.jacobians, at + 2 * width + b, BLOCK),
            )  # fmt: skip
            value = add(add(cross(slope[0], x), slope[1]), cross(spin, arm))
            simd_store(rates.points, at + b, value[0])
            simd_store(rates.points, at + width + b, value[1])
            simd_store(rates.points, at + 2 * width + b, value[2])
