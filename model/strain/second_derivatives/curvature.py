"""Second derivatives of a shape by its strains: exact for the discrete shape, as its Jacobians are.

With the spatial twist X_a of a node by the mode a, and the part Y_a of it that an interval adds, [,] the Lie bracket,

    dY_a/dq_b = [X_b, Y_a] + Ad_g d/dq_b (J(psi) dpsi/dq_a),

X_b of the interval's base, g its pose, psi its Magnus twist and J the left Jacobian. For twists in space J is a
polynomial of degree four of ad(psi), with coefficients of the squared angle alone (T. D. Barfoot, State Estimation for
Robotics, 2017, equation 7.86), so that its derivative takes a few brackets.
"""

from typing import Any

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.products import BLOCK, HALF, Lines, add_products, padded
from tendond.model.numerics.simd import simd_load, simd_multiply_add, simd_store
from tendond.model.numerics.vectors import add, cross, dot, plus_outer, rotate_back, scale
from tendond.model.strain.composites import NONE, ZERO, add_three, own_lanes, turned_push, write_turn
from tendond.model.strain.directions import DIRECTIONS, by_modes
from tendond.model.strain.kinematics import Shape, axis_of, point_of, rotation_of, strain_of
from tendond.model.strain.layout import Layout
from tendond.model.strain.second_derivatives.bends import Bends
from tendond.model.strain.twists import (
    COMMUTATOR,
    Six,
    bracket,
    load_six,
    magnus,
    magnus_change,
    pair,
    plus,
    polynomial,
    store_six,
    store_three,
    times,
    transposed,
)


@inlined
def _add_interval(layout: Layout, k: int, shape: Shape, wrench: Six, room: Bends) -> None:
    """Add to `room.own` a matrix whose symmetric part is an interval's own second derivative."""
    first, last, h, width = layout.first[k], layout.last[k], layout.step[k], padded(len(layout.component))
    r, p = rotation_of(shape, k), (shape.position[k, 0], shape.position[k, 1], shape.position[k, 2])
    l0 = rotate_back(r, add(wrench[0], cross(wrench[1], p))), rotate_back(r, wrench[1])
    one, two = strain_of(shape, k, 0), strain_of(shape, k, 1)
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
    change, dual, pull, unit, base = room.change, room.dual, room.pull, room.directions.unit, room.directions.base[k]
    for group in range(room.directions.groups[k]):
        at = group * HALF
        e1, e2 = load_six(unit, base + at, DIRECTIONS), load_six(unit, base + 6 * DIRECTIONS + at, DIRECTIONS)
        t0 = magnus_change(h, e1, e2, one, two)
        t1 = bracket(psi, t0)
        t2 = bracket(psi, t1)
        t3 = bracket(psi, t2)
        # t . dual(t') + 2 (psi . t) z . t' is the product of z and y with the derivatives of the brackets
        both = plus(plus(transposed(t0, y0), transposed(t1, y1)), plus(transposed(t2, y2), transposed(t3, y3)))
        along = pair(z, t0) * 2.0
        u = add(scale(-1.0, both[0]), (along * psi[0][0], along * psi[0][1], along * psi[0][2]))
        store_six(change, at, DIRECTIONS, t0)
        store_six(dual, at, DIRECTIONS, (u, scale(-1.0, both[1])))
        turned = plus(transposed(e1, whole), times(-1.0, transposed(e2, whole)))
        store_six(pull, at, DIRECTIONS, times(COMMUTATOR * h * h, turned))
    block, spread, total = room.block, room.spread, room.own
    for row in range(room.directions.groups[k] * HALF):
        against = base + 6 * DIRECTIONS * (1 - row % 2)
        for at in range(0, room.directions.groups[k] * HALF, HALF):
            value, other = change[row] * simd_load(dual, at, BLOCK), pull[row] * simd_load(unit, against + at, BLOCK)
            for c in range(DIRECTIONS, 6 * DIRECTIONS, DIRECTIONS):
                value = simd_multiply_add(change[c + row], simd_load(dual, c + at, BLOCK), value)
                other = simd_multiply_add(pull[c + row], simd_load(unit, against + c + at, BLOCK), other)
            simd_store(block, row * DIRECTIONS + at, value + other)
        for b in range(room.directions.begin[k], last, HALF):
            simd_store(spread, row * width + b, by_modes(room.directions, k, block, row, b))
    for d in range(first, last):
        above, below = 2 * room.directions.slot[d] * width, (2 * room.directions.slot[d] + 1) * width
        for b in range(room.directions.begin[k], last, HALF):
            value = simd_load(total, d * width + b, BLOCK)
            value = simd_multiply_add(layout.at1[k, d], simd_load(spread, above + b, BLOCK), value)
            value = simd_multiply_add(layout.at2[k, d], simd_load(spread, below + b, BLOCK), value)
            simd_store(total, d * width + b, value)


@lean
def add_curvature(layout: Layout, shape: Shape, force: Any, moment: Any, spin: Any, room: Bends, out: Any) -> None:
    """Add sum force . d2x_a/dq_b + sum moment . d(turn_a)/dq_b + sum spin d(own turn_a)/dq_b to out[a, b].

    `force` acts on the mass points, shape (P, 3), `moment` on the nodes, shape (K + 1, 3), dead, world frame; `spin`
    about each node's own axis, shape (K + 1,). Only the moments' part is not symmetric.
    """
    n, width, stride, spans = len(out), padded(len(out)), shape.spin.shape[1], shape.spans
    left, other, right, narrow = room.left, room.other, room.right, spans.width[0]
    room.total[:], room.second[:], room.own[:] = 0.0, 0.0, 0.0
    f, dead, own, lever = NONE, NONE, NONE, NONE  # forces beyond, moments, moments about own axes, sum of x x force
    moments = ZERO  # sum of x force' over the points beyond
    j = len(layout.mass) - 1
    for s in range(len(spans.first) - 1, -1, -1):
        base, block, first, last, row = spans.node[s], spans.block[s], spans.first[s], spans.last[s], 0
        room.pushes[:], room.others[:] = 0.0, 0.0
        for k in range(spans.node[s + 1] - 1, base - 1, -1):
            while j >= 0 and layout.place[j] == k + 1:
                x, pull = point_of(shape.point, j), point_of(force, j)
                moments = plus_outer(moments, x, pull)
                f, lever = add(f, pull), add(lever, cross(x, pull))
                j -= 1
            dead = add(dead, point_of(moment, k + 1))
            own = add(own, scale(spin[k + 1], axis_of(shape, k + 1, 2)))
            for b in range(block, last, HALF):
                part, at = load_six(shape.parts, 6 * k * stride + b, stride), row * narrow + b - block
                x = turned_push(moments, f, part)
                y, z = add(x, cross(part[0], dead)), add(x, cross(part[0], own))
                store_three(left, at, narrow, y)
                store_three(other, at, narrow, z)
                write_turn(shape, k, b, own_lanes(spans, s, b), right, at, narrow)
                if first > 0:
                    add_three(room.pushes, b - block, narrow, y)
                    add_three(room.others, b - block, narrow, z)
            row += 3
            wrench = add(lever, add(dead, own)), f
            if wrench != (NONE, NONE):
                _add_interval(layout, k, shape, wrench, room)
        at, mine, by = 6 * base * stride, (first - block, last - block), (0, last - block)
        turns, before = Lines(right, 0, narrow), Lines(shape.twists, at, stride)
        corner, edge = block * width + block, block * width
        add_products(Lines(left, 0, narrow), turns, row, mine, by, Lines(room.total, corner, width))
        add_products(Lines(other, 0, narrow), turns, row, mine, by, Lines(room.second, corner, width))
        add_products(Lines(room.pushes, 0, narrow), before, 3, mine, (0, first), Lines(room.total, edge, width))
        add_products(Lines(room.others, 0, narrow), before, 3, mine, (0, first), Lines(room.second, edge, width))
    for a in range(n):
        for b in range(n):
            own_part = room.own[a * width + b] + room.own[b * width + a]
            out[a, b] += room.total[a * width + b] + room.second[b * width + a] + 0.5 * own_part
