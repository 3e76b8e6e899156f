"""Derivatives of what acts in the balance of a step: mass points' forces, tendons' pulls, dead moments."""

from typing import Any

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.products import add_products, padded
from tendond.model.strain.derivatives.curvature import add_curvature
from tendond.model.strain.derivatives.room import Room
from tendond.model.strain.kinematics import Shape
from tendond.model.strain.layout import Layout
from tendond.model.strain.stepping.scratch import Loads, Scratch
from tendond.model.strain.tendons import add_tendon_stiffness


@inlined
def _slope_before(layout: Layout, loads: Loads, i: int, work: Scratch) -> float:
    """Return the derivative of a driven tendon's mean tension by its displacement at the start; see `find_residual`."""
    k = layout.tendon_stiffness[i]
    before = loads.tension[i] - work.paths_before.displacement[i]
    after = loads.tension[i] - work.paths_after.displacement[i]
    value = 0.0
    if before > 0.0 and after > 0.0:
        value = -0.5 * k
    elif before > 0.0:
        value = -(k * before - work.taut[i]) / (before - after)
    elif after > 0.0:
        value = -work.taut[i] / (after - before)
    return value


@inlined
def _add_drag(shape: Shape, k: int, j: int, c: int, factors: Any, along: Any, ahead: float, into: Any, at: int) -> None:
    """Add what a point's drag along the axis c does when that end of the step moves: `ahead` is 1 at its end, or -1."""
    r, x, drag, slope = along[0], along[1], factors[0], factors[1]
    width = padded(shape.spin.shape[1])
    a0, a1, a2 = shape.rotation[k, c], shape.rotation[k, 3 + c], shape.rotation[k, 6 + c]
    for b in range(shape.spin.shape[1]):
        w0, w1, w2 = shape.twist[k, 0, b], shape.twist[k, 1, b], shape.twist[k, 2, b]
        g0, g1, g2 = 0.5 * (w1 * a2 - w2 * a1), 0.5 * (w2 * a0 - w0 * a2), 0.5 * (w0 * a1 - w1 * a0)
        moved = slope * (
            g0 * x[0] + g1 * x[1] + g2 * x[2] + ahead * (
                r[0] * shape.jacobian[j, 0, b] + r[1] * shape.jacobian[j, 1, b] + r[2] * shape.jacobian[j, 2, b]
            )
        )  # fmt: skip
        into[at + b] += moved * r[0] + drag * g0
        into[at + width + b] += moved * r[1] + drag * g1
        into[at + 2 * width + b] += moved * r[2] + drag * g2


@lean
def write_points(layout: Layout, h: float, work: Scratch, room: Room) -> None:
    """Write the rows of the mass points' forces; add those of their work to `room.lack` and `row`."""
    n, width = len(room.lack), padded(len(room.lack))
    left, after, before, rate, lack, row = room.left, room.after, room.before, room.rate, room.lack, room.row
    one, two, motion = work.before, work.after, room.rates0.point
    for j in range(len(layout.mass)):
        k, c = layout.place[j], 2.0 * layout.mass[j] / h
        last, at = layout.last[k - 1], 3 * j * width
        x = (two.point[j, 0] - one.point[j, 0], two.point[j, 1] - one.point[j, 1], two.point[j, 2] - one.point[j, 2])
        for i in range(3):
            here = at + i * width
            for b in range(last):
                j0, j1 = one.jacobian[j, i, b], two.jacobian[j, i, b]
                left[here + b] = 0.5 * (j0 + j1)
                after[here + b] = c / h * j1
                before[here + b] = -c * (j0 / h + motion[j, i, b])
                rate[here + b] = -c * j0
        for axis in range(3):
            if layout.drag[j, axis] == 0.0:
                continue
            r = (
                0.5 * (one.rotation[k, axis] + two.rotation[k, axis]),
                0.5 * (one.rotation[k, 3 + axis] + two.rotation[k, 3 + axis]),
                0.5 * (one.rotation[k, 6 + axis] + two.rotation[k, 6 + axis]),
            )
            speed = (r[0] * x[0] + r[1] * x[1] + r[2] * x[2]) / h
            factors = layout.drag[j, axis] * speed * abs(speed), 2.0 * layout.drag[j, axis] * abs(speed) / h
            _add_drag(one, k, j, axis, factors, (r, x), -1.0, before, at)
            _add_drag(two, k, j, axis, factors, (r, x), 1.0, after, at)
        for i in range(3):
            force, here = work.force[j, i], at + i * width
            for b in range(last):
                lack[b] += x[i] * after[here + b] + force * two.jacobian[j, i, b]
                row[b] += x[i] * before[here + b] - force * one.jacobian[j, i, b]
                row[n + b] += x[i] * rate[here + b]


@lean
def add_pulls(layout: Layout, loads: Loads, work: Scratch, room: Room) -> None:
    """Add the derivatives of the tendons' pulls by both ends and by the actuation."""
    n, width = len(room.lack), padded(len(room.lack))
    columns = len(room.by_input) // n
    begin = 3 * len(layout.mass) + len(layout.step)
    g0, g1 = work.paths_before.gradient, work.paths_after.gradient
    driven = False
    for i in range(len(work.taut)):
        s1, s0, given = 0.0, 0.0, 1.0
        if loads.driven[i]:
            s1, s0 = work.slack[i], _slope_before(layout, loads, i, work)
            given = -(s0 + s1)
            driven = True
        change = work.paths_after.displacement[i] - work.paths_before.displacement[i]
        room.row[2 * n + i] -= given * change
        at = (begin + i) * width
        for b in range(n):
            room.lack[b] -= (s1 * change + work.taut[i]) * g1[i, b]
            room.row[b] -= (s0 * change - work.taut[i]) * g0[i, b]
            mean = 0.5 * (g0[i, b] + g1[i, b])
            room.by_input[b * columns + 2 * n + i] -= given * mean
            room.left[at + b], room.after[at + b], room.before[at + b] = mean, -s1 * g1[i, b], -s0 * g0[i, b]
    if driven:
        end = begin + len(work.taut)
        add_products(room.left, room.after, width, begin, end, 0, n, n, room.by_q1)
        add_products(room.left, room.before, width, begin, end, 0, n, n, room.by_q0)


@lean
def add_bend(layout: Layout, q: Any, shape: Any, paths: Any, work: Scratch, room: Room, out: Any) -> None:
    """Add half of what forces, tensions and own moments do through second derivatives."""
    room.curvature[:, :] = 0.0
    room.moment[:, :] = 0.0
    add_curvature(layout, q, shape, work.force, room.moment, work.torque, room.bends, room.curvature)
    if len(work.taut) > 0:
        add_tendon_stiffness(layout, q, work.taut, 1.0, paths, room.curvature)
    add_half(room, out)


@lean
def add_turn(layout: Layout, loads: Loads, q: Any, shape: Any, room: Room, out: Any) -> None:
    """Add half of what dead moments do through second derivatives."""
    any_moment = False
    for k in range(len(layout.polar)):
        room.torque[k] = 0.0
        for i in range(3):
            room.moment[k, i] = -loads.moment[k, i]
            any_moment |= loads.moment[k, i] != 0.0
    if any_moment:
        room.force[:, :] = 0.0
        room.curvature[:, :] = 0.0
        add_curvature(layout, q, shape, room.force, room.moment, room.torque, room.bends, room.curvature)
        add_half(room, out)


@inlined
def add_half(room: Room, out: Any) -> None:
    """Add half of `room.curvature` to padded rows."""
    n, width = len(room.lack), padded(len(room.lack))
    for a in range(n):
        for b in range(n):
            out[a * width + b] += 0.5 * room.curvature[a, b]
