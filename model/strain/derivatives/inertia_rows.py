"""Rows of mass points, three each, and of nodes that turn about their axes, one each, for the derivatives of a step.

They are those of its balance, and of the momentum after it.

A row of `left` times one of `after`, `before` or `rate` is what each adds to the derivatives by q1, q0 and w0.
"""

from typing import Any

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.products import BLOCK, HALF, padded
from tendond.model.numerics.simd import simd_load, simd_store
from tendond.model.numerics.vectors import Matrix, Vector, add, cross, dot, plus_outer, rotate, scale, sub
from tendond.model.strain.derivatives.room import Room
from tendond.model.strain.kinematics import Shape
from tendond.model.strain.layout import Layout
from tendond.model.strain.stepping.scratch import Scratch
from tendond.model.strain.twists import load_three, store_three

ZERO = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@inlined
def _axis(shape: Shape, k: int, c: int) -> Vector:
    """Return an axis of a node's frame."""
    return shape.rotation[k, c], shape.rotation[k, 3 + c], shape.rotation[k, 6 + c]


@inlined
def _point(values: Any, j: int) -> Vector:
    """Return the vector of a mass point."""
    return values[j, 0], values[j, 1], values[j, 2]


@inlined
def _by_turn(turned: Matrix, r: Vector, x: Vector, axis: Vector, drag: float, slope: float) -> Matrix:
    """Add what drag along r does when its axis turns with one end: -(slope r (x x axis)' + drag [axis]) / 2."""
    a0, a1, a2 = scale(0.5 * drag, axis)
    m = plus_outer(turned, scale(-0.5 * slope, r), cross(x, axis))
    return m[0], m[1] + a2, m[2] - a1, m[3] - a2, m[4], m[5] + a0, m[6] + a1, m[7] - a0, m[8]


@inlined
def _find_drag(layout: Layout, h: float, work: Scratch, j: int) -> tuple[Matrix, Matrix, Matrix]:
    """Return derivatives of a point's drag: by its own move, by the turn before the step, and by that after it."""
    k, one, two = layout.place[j], work.before, work.after
    x = sub(_point(two.point, j), _point(one.point, j))
    moved, turned0, turned1 = ZERO, ZERO, ZERO
    for c in range(3):
        a0, a1 = _axis(one, k, c), _axis(two, k, c)
        r = scale(0.5, add(a0, a1))
        speed = dot(r, x) / h
        drag, slope = layout.drag[j, c] * speed * abs(speed), 2.0 * layout.drag[j, c] * abs(speed) / h
        moved = plus_outer(moved, scale(slope, r), r)
        turned0 = _by_turn(turned0, r, x, a0, drag, slope)
        turned1 = _by_turn(turned1, r, x, a1, drag, slope)
    return moved, turned0, turned1


@lean
def write_points(layout: Layout, h: float, work: Scratch, room: Room) -> None:
    """Write the rows of the points' forces in the balance; add those of their work to `room.lack` and `early`."""
    width, stride, one, two = padded(len(layout.component)), work.after.spin.shape[1], work.before, work.after
    for j in range(len(layout.mass)):
        k, c = layout.place[j], 2.0 * layout.mass[j] / h
        x, f = sub(_point(two.point, j), _point(one.point, j)), _point(work.force, j)
        dragged = layout.drag[j, 0] != 0.0 or layout.drag[j, 1] != 0.0 or layout.drag[j, 2] != 0.0
        moved, turned0, turned1 = _find_drag(layout, h, work, j) if dragged else (ZERO, ZERO, ZERO)
        for b in range(0, layout.last[k - 1], HALF):
            at, to = 3 * j * stride + b, 3 * j * width + b
            j0, j1 = load_three(one.jacobians, at, stride), load_three(two.jacobians, at, stride)
            motion = load_three(room.rates0.points, at, stride)
            after, before, rate = scale(c / h, j1), scale(-c, add(scale(1.0 / h, j0), motion)), scale(-c, j0)
            if dragged:
                u0 = load_three(one.twists, 6 * k * stride + b, stride)
                u1 = load_three(two.twists, 6 * k * stride + b, stride)
                after = add(after, add(rotate(moved, j1), rotate(turned1, u1)))
                before = add(before, sub(rotate(turned0, u0), rotate(moved, j0)))
            store_three(room.left, to, width, scale(0.5, add(j0, j1)))
            store_three(room.after, to, width, after)
            store_three(room.before, to, width, before)
            store_three(room.rate, to, width, rate)
            simd_store(room.lack, b, simd_load(room.lack, b, BLOCK) + dot(after, x) + dot(j1, f))
            simd_store(room.early, b, simd_load(room.early, b, BLOCK) + dot(before, x) - dot(j0, f))
            simd_store(room.early, width + b, simd_load(room.early, width + b, BLOCK) + dot(rate, x))


@lean
def write_momenta(layout: Layout, h: float, work: Scratch, room: Room) -> None:
    """Write the rows of the points' momenta after the step."""
    width, stride, one, two = padded(len(layout.component)), work.after.spin.shape[1], work.before, work.after
    for j in range(len(layout.mass)):
        m = layout.mass[j]
        for b in range(0, layout.last[layout.place[j] - 1], HALF):
            at, to = 3 * j * stride + b, 3 * j * width + b
            j0, j1 = load_three(one.jacobians, at, stride), load_three(two.jacobians, at, stride)
            motion0, motion1 = load_three(room.rates0.points, at, stride), load_three(room.rates1.points, at, stride)
            store_three(room.left, to, width, scale(m, j1))
            store_three(room.after, to, width, sub(scale(2.0 / h, j1), motion1))
            store_three(room.before, to, width, sub(scale(-2.0 / h, j0), motion0))
            store_three(room.rate, to, width, scale(-1.0, j0))


@lean
def write_nodes(layout: Layout, h: float, work: Scratch, room: Room) -> None:
    """Write the rows of the nodes' inertia in the balance."""
    width, stride, one, two = padded(len(layout.component)), work.after.spin.shape[1], work.before, work.after
    for k in range(1, len(layout.polar)):
        factor, row = layout.polar[k] / h, (3 * len(layout.mass) + k - 1) * width
        for b in range(0, layout.last[k - 1], HALF):
            at, to = k * stride + b, row + b
            own = simd_load(one.spins, at, BLOCK)
            both = own + simd_load(two.spins, at, BLOCK)
            spin0, spin1 = simd_load(room.spins0, at, BLOCK), simd_load(room.spins1, at, BLOCK)
            simd_store(room.left, to, factor * both)
            simd_store(room.after, to, (both + spin1) * (0.5 / h))
            simd_store(room.before, to, (spin0 - both) * (0.5 / h) - simd_load(room.rates0.spins, at, BLOCK))
            simd_store(room.rate, to, -own)


@lean
def write_node_momenta(layout: Layout, h: float, work: Scratch, room: Room) -> None:
    """Write the rows of the nodes' momenta after the step."""
    width, stride, one, two = padded(len(layout.component)), work.after.spin.shape[1], work.before, work.after
    for k in range(1, len(layout.polar)):
        row = (3 * len(layout.mass) + k - 1) * width
        for b in range(0, layout.last[k - 1], HALF):
            at, to = k * stride + b, row + b
            own, after = simd_load(one.spins, at, BLOCK), simd_load(two.spins, at, BLOCK)
            both = own + after
            spin0, spin1 = simd_load(room.spins0, at, BLOCK), simd_load(room.spins1, at, BLOCK)
            simd_store(room.left, to, layout.polar[k] * after)
            simd_store(room.after, to, (both + spin1) * (1.0 / h) - simd_load(room.rates1.spins, at, BLOCK))
            simd_store(room.before, to, (spin0 - both) * (1.0 / h) - simd_load(room.rates0.spins, at, BLOCK))
            simd_store(room.rate, to, -own)
