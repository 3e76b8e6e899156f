"""Second derivatives of a shape by its strains: exact for the discrete shape, as its Jacobians are.

With the spatial twist X_a of a node by the mode a, and the part Y_a of it that an interval adds, [,] the Lie bracket,

    dY_a/dq_b = [X_b, Y_a] + Ad_g d/dq_b (J(psi) dpsi/dq_a),

X_b of the interval's base, g its pose, psi its Magnus twist and J the left Jacobian. For twists in space J is a
polynomial of degree four of ad(psi), with coefficients of the squared angle alone (T. D. Barfoot, State Estimation for
Robotics, 2017, equation 7.86), so that its derivative takes a few brackets.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, kernel
from tendond.model.numerics.parked import park
from tendond.model.numerics.vectors import Matrix, Vector, add, cross, dot, rotate, rotate_back, scale
from tendond.model.strain.kinematics import COMMUTATOR, Shape
from tendond.model.strain.layout import Layout

Array = NDArray[np.float64]
Six = tuple[Vector, Vector]

SERIES = 4.0
"""[rad^2] Of the squared angle, below which series take the place of quotients; they are exact to rounding there."""


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


@inlined
def polynomial(x: float) -> tuple[float, float, float, float, float, float, float, float]:
    """Return the coefficients of ad, ad^2, ad^3, ad^4 in the left Jacobian, then their derivatives by x = t^2.

    All follow from the tails r, t, s, d, c, b of the series of sine and cosine: b = (1 - cos t) / t^2 and
    c = (t - sin t) / t^3 with b' = d - c / 2, c' = -e, e = (d - 3 s) / 2.
    """
    if x < SERIES:
        t = (1.0 - x / 56.0 * (1.0 - x / 90.0 * (1.0 - x / 132.0 * (1.0 - x / 182.0 * (1.0 - x / 240.0 * (
            1.0 - x / 306.0 * (1.0 - x / 380.0 * (1.0 - x / 462.0)))))))) / 720.0  # fmt: skip
        r = (1.0 - x / 72.0 * (1.0 - x / 110.0 * (1.0 - x / 156.0 * (1.0 - x / 210.0 * (1.0 - x / 272.0 * (
            1.0 - x / 342.0 * (1.0 - x / 420.0 * (1.0 - x / 506.0)))))))) / 5040.0  # fmt: skip
        s, d = 1.0 / 120.0 - x * r, 1.0 / 24.0 - x * t
        c, b = 1.0 / 6.0 - x * s, 0.5 - x * d
    else:
        root = math.sqrt(x)
        b = (1.0 - math.cos(root)) / x
        c = (1.0 - math.sin(root) / root) / x
        s, d = (1.0 / 6.0 - c) / x, (0.5 - b) / x
        r, t = (1.0 / 120.0 - s) / x, (1.0 / 24.0 - d) / x
    e = 0.5 * (d - 3.0 * s)
    third = 0.5 * c - d
    b2 = 2.0 * t + 0.25 * d - 1.25 * s
    c2 = 3.75 * r + 0.25 * s - 1.75 * t
    return b + x * third, c + x * e, third, e, -x * b2, -x * c2, -b2, -c2


@inlined
def bracket(a: Six, b: Six) -> Six:
    """Return the Lie bracket of two twists."""
    return cross(a[0], b[0]), add(cross(a[0], b[1]), cross(a[1], b[0]))


@inlined
def plus(a: Six, b: Six) -> Six:
    """Return a + b."""
    return add(a[0], b[0]), add(a[1], b[1])


@inlined
def times(k: float, a: Six) -> Six:
    """Return k a."""
    return scale(k, a[0]), scale(k, a[1])


@inlined
def pair(a: Six, b: Six) -> float:
    """Return the product of a wrench and a twist."""
    value: float = dot(a[0], b[0]) + dot(a[1], b[1])
    return value


@inlined
def transposed(f: Six, w: Six) -> Six:
    """Return the wrench ad(f)' w: its product with a twist a is that of w with [f, a]."""
    return add(cross(w[0], f[0]), cross(w[1], f[1])), cross(w[1], f[0])


@inlined
def direction(c: int) -> Six:
    """Return the unit strain of a component."""
    u = (1.0 if c == 0 else 0.0, 1.0 if c == 1 else 0.0, 1.0 if c == 2 else 0.0)
    v = (1.0 if c == 3 else 0.0, 1.0 if c == 4 else 0.0, 1.0 if c == 5 else 0.0)
    return u, v


@inlined
def strain(layout: Layout, q: Any, k: int, at: Any, reference: Any) -> Six:
    """Return the strain of interval k where the modes have the values `at`; of rates, where `reference` is 0."""
    x0, x1, x2 = reference[k, 0], reference[k, 1], reference[k, 2]
    y0, y1, y2 = reference[k, 3], reference[k, 4], reference[k, 5]
    for d in range(layout.first[k], layout.last[k]):
        c, value = layout.component[d], at[k, d] * q[d]
        if c == 0:
            x0 += value
        elif c == 1:
            x1 += value
        elif c == 2:
            x2 += value
        elif c == 3:
            y0 += value
        elif c == 4:
            y1 += value
        else:
            y2 += value
    return (x0, x1, x2), (y0, y1, y2)


@inlined
def _rotation(shape: Shape, k: int) -> Matrix:
    r = shape.rotation[k]
    return r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]


@inlined
def _of(twists: Any, k: int, d: int) -> Six:
    """Return the twist of node or interval k by the mode d."""
    return (twists[k, 0, d], twists[k, 1, d], twists[k, 2, d]), (twists[k, 3, d], twists[k, 4, d], twists[k, 5, d])


@inlined
def _jacobian(shape: Shape, j: int, d: int) -> Vector:
    """Return how the mass point j moves by the mode d."""
    return shape.jacobian[j, 0, d], shape.jacobian[j, 1, d], shape.jacobian[j, 2, d]


@inlined
def _twist(h: float, one: Six, two: Six) -> Six:
    """Return the Magnus twist of an interval from the strains at its Gauss points."""
    psi: Six = plus(times(0.5 * h, plus(one, two)), times(COMMUTATOR * h * h, bracket(one, two)))
    return psi


@inlined
def _change(h: float, point: int, one: Six, two: Six, by: Six) -> Six:
    """Return the derivative of the Magnus twist by the strain at one of the Gauss points, in the direction `by`."""
    turned = bracket(by, two) if point == 0 else bracket(one, by)
    change: Six = plus(times(0.5 * h, by), times(COMMUTATOR * h * h, turned))
    return change


@inlined
def _components(layout: Layout, k: int) -> int:
    """Return the components of the strain that have modes in an interval, as bits."""
    found = 0
    for d in range(layout.first[k], layout.last[k]):
        found |= 1 << layout.component[d]
    return found


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
        psi = _twist(h, one, two)
        c1, c2, c3, c4, d1, d2, d3, d4 = polynomial(dot(psi[0], psi[0]))
        t0 = plus(_change(h, 0, one, two, moved1), _change(h, 1, one, two, moved2))
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
        r, p = _rotation(shape, k), (shape.position[k, 0], shape.position[k, 1], shape.position[k, 2])
        there = _components(layout, k)
        for c in range(6):
            if not there & (1 << c):
                continue
            e = direction(c)
            for point in range(2):
                by = _change(h, point, one, two, e)
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
            turned = bracket(_of(shape.twist, k, d), (u, v))
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
            turn, slope = _of(shape.twist, k + 1, d)[0], _of(rates.slope, k + 1, d)[0]
            rates.spin[k + 1, d] = dot(turn, across) + dot(axis, slope)
    for j in range(len(layout.mass)):
        k = layout.place[j]
        x = (shape.point[j, 0], shape.point[j, 1], shape.point[j, 2])
        spin = (rates.node[k, 0], rates.node[k, 1], rates.node[k, 2])
        for d in range(n):
            slope = _of(rates.slope, k, d)
            value = add(add(cross(slope[0], x), slope[1]), cross(spin, _jacobian(shape, j, d)))
            rates.point[j, 0, d], rates.point[j, 1, d], rates.point[j, 2, d] = value


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
            t = _of(shape.part, k, d)
            a = t[0]
            x = (
                sum_of[0] * a[0] + sum_of[1] * a[1] + sum_of[2] * a[2] - trace * a[0],
                sum_of[3] * a[0] + sum_of[4] * a[1] + sum_of[5] * a[2] - trace * a[1],
                sum_of[6] * a[0] + sum_of[7] * a[1] + sum_of[8] * a[2] - trace * a[2],
            )
            x = add(x, cross(t[1], f))
            for e in range(last):
                turn = _of(shape.twist, k, e)[0]
                value = dot(turn, x)
                if e >= first:
                    value += 0.5 * dot(_of(shape.part, k, e)[0], x)
                out[d, e] += value
                out[e, d] += value
                if turning or loaded:
                    across = cross(turn, a)
                    if e >= first:
                        across = add(across, scale(0.5, cross(_of(shape.part, k, e)[0], a)))
                    out[e, d] += dot(own, across)
                    out[d, e] += dot(dead, across)
        wrench = add(lever, add(dead, own)), f
        if wrench == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)):
            continue
        # the symmetric part of an interval's own second derivative
        r, p = _rotation(shape, k), (shape.position[k, 0], shape.position[k, 1], shape.position[k, 2])
        l0 = rotate_back(r, add(wrench[0], cross(wrench[1], p))), rotate_back(r, wrench[1])
        one, two = strain(layout, q, k, layout.at1, layout.strain1), strain(layout, q, k, layout.at2, layout.strain2)
        psi = _twist(h, one, two)
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
        there = _components(layout, k)
        for c in range(6):
            if not there & (1 << c):
                continue
            for point in range(2):
                t = _change(h, point, one, two, direction(c))
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
        r = _rotation(shape, k)
        there = _components(layout, k)
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
