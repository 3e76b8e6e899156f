"""Derivatives of what acts in the balance of a step: mass points' forces, tendons' pulls, dead moments."""

from typing import Any

from tendond.model.numerics.compile import inlined, kernel
from tendond.model.strain.derivatives.curvature import add_curvature
from tendond.model.strain.derivatives.room import Room
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


@kernel
def add_points(layout: Layout, h: float, work: Scratch, room: Room) -> None:
    """Add the derivatives of the mass points' forces; `room.lack`, `row`: of their work."""
    n = len(room.lack)
    r1, rx, lack, row = room.by_q1, room.by_input, room.lack, room.row
    one, two = work.before, work.after
    d0, d1 = room.by_force0, room.by_force1
    for j in range(len(layout.mass)):
        k, c = layout.place[j], 2.0 * layout.mass[j] / h
        last = layout.last[k - 1]
        x = (two.point[j, 0] - one.point[j, 0], two.point[j, 1] - one.point[j, 1], two.point[j, 2] - one.point[j, 2])
        for i in range(3):
            for b in range(last):
                d1[i, b] = c / h * two.jacobian[j, i, b]
                d0[i, b] = -c * (one.jacobian[j, i, b] / h + room.rates0.point[j, i, b])
        for axis in range(3):
            if layout.drag[j, axis] == 0.0:
                continue
            a0 = (one.rotation[k, axis], one.rotation[k, 3 + axis], one.rotation[k, 6 + axis])
            a1 = (two.rotation[k, axis], two.rotation[k, 3 + axis], two.rotation[k, 6 + axis])
            r = (0.5 * (a0[0] + a1[0]), 0.5 * (a0[1] + a1[1]), 0.5 * (a0[2] + a1[2]))
            speed = (r[0] * x[0] + r[1] * x[1] + r[2] * x[2]) / h
            drag, slope = layout.drag[j, axis] * speed * abs(speed), 2.0 * layout.drag[j, axis] * abs(speed) / h
            for end in range(2):
                shape, axis_of, into, sign = (one, a0, d0, -1.0) if end == 0 else (two, a1, d1, 1.0)
                for b in range(last):
                    w0, w1, w2 = shape.twist[k, 0, b], shape.twist[k, 1, b], shape.twist[k, 2, b]
                    g0 = 0.5 * (w1 * axis_of[2] - w2 * axis_of[1])
                    g1 = 0.5 * (w2 * axis_of[0] - w0 * axis_of[2])
                    g2 = 0.5 * (w0 * axis_of[1] - w1 * axis_of[0])
                    along = g0 * x[0] + g1 * x[1] + g2 * x[2] + sign * (
                        r[0] * shape.jacobian[j, 0, b] + r[1] * shape.jacobian[j, 1, b] + r[2] * shape.jacobian[j, 2, b]
                    )  # fmt: skip
                    into[0, b] += slope * along * r[0] + drag * g0
                    into[1, b] += slope * along * r[1] + drag * g1
                    into[2, b] += slope * along * r[2] + drag * g2
        for i in range(3):
            force = work.force[j, i]
            for b in range(last):
                lack[b] += x[i] * d1[i, b] + force * two.jacobian[j, i, b]
                row[b] += x[i] * d0[i, b] - force * one.jacobian[j, i, b]
                row[n + b] -= c * x[i] * one.jacobian[j, i, b]
            for a in range(last):
                mean = 0.5 * (one.jacobian[j, i, a] + two.jacobian[j, i, a])
                moved = -c * mean
                for b in range(last):
                    r1[a, b] += mean * d1[i, b]
                for b in range(last):
                    rx[a, b] += mean * d0[i, b]
                for b in range(last):
                    rx[a, n + b] += moved * one.jacobian[j, i, b]


@kernel
def add_pulls(layout: Layout, loads: Loads, work: Scratch, room: Room) -> None:
    """Add the derivatives of the tendons' pulls by both ends and by the actuation."""
    n = len(room.lack)
    g0, g1 = work.paths_before.gradient, work.paths_after.gradient
    for i in range(len(work.taut)):
        s1, s0, given = 0.0, 0.0, 1.0
        if loads.driven[i]:
            s1, s0 = work.slack[i], _slope_before(layout, loads, i, work)
            given = -(s0 + s1)
        way = work.paths_after.displacement[i] - work.paths_before.displacement[i]
        for b in range(n):
            room.lack[b] -= (s1 * way + work.taut[i]) * g1[i, b]
            room.row[b] -= (s0 * way - work.taut[i]) * g0[i, b]
        room.row[2 * n + i] -= given * way
        for a in range(n):
            mean = 0.5 * (g0[i, a] + g1[i, a])
            room.by_input[a, 2 * n + i] -= given * mean
            if s0 != 0.0 or s1 != 0.0:
                for b in range(n):
                    room.by_q1[a, b] -= s1 * mean * g1[i, b]
                    room.by_input[a, b] -= s0 * mean * g0[i, b]


@kernel
def bend(layout: Layout, q: Any, shape: Any, paths: Any, work: Scratch, room: Room) -> None:
    """Write to `room.curvature` what forces, tensions and own moments do through second derivatives."""
    room.curvature[:, :] = 0.0
    room.moment[:, :] = 0.0
    add_curvature(layout, q, shape, work.force, room.moment, work.torque, room.curvature)
    if len(work.taut) > 0:
        add_tendon_stiffness(layout, q, work.taut, 1.0, paths, room.curvature)


@kernel
def turn(layout: Layout, loads: Loads, q: Any, shape: Any, room: Room) -> bool:
    """Write to `room.curvature` what dead moments do; false where there are none."""
    any_moment = False
    for k in range(len(layout.polar)):
        room.torque[k] = 0.0
        for i in range(3):
            room.moment[k, i] = -loads.moment[k, i]
            any_moment |= loads.moment[k, i] != 0.0
    if any_moment:
        room.force[:, :] = 0.0
        room.curvature[:, :] = 0.0
        add_curvature(layout, q, shape, room.force, room.moment, room.torque, room.curvature)
    return any_moment
