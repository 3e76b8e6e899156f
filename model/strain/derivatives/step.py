"""Derivatives of one step of the strain rod by state, actuation and loads: its balance, differentiated.

With the balance R(q1; q0, w0, inputs) = 0 of a step and the rates w1 after it, M(q1) w1 = p(q0, w0, q1),

    dq1 = -R_q1^-1 R_x dx,    M dw1 = (p_q1 - (M w1)_q1) dq1 + p_x dx.

All terms are exact for the discrete rod, the balance's share and the derivatives of the Jacobians among them.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, kernel
from tendond.model.numerics.linear import factor_lu, factor_symmetric
from tendond.model.numerics.parked import park
from tendond.model.strain.derivatives.columns import solve_lu_columns, solve_symmetric_columns
from tendond.model.strain.derivatives.curvature import Rates, add_curvature, empty_rates, find_rates, find_spins
from tendond.model.strain.equations import Loads, Scratch, mass_matrix
from tendond.model.strain.layout import Layout
from tendond.model.strain.tendons import add_tendon_stiffness

Array = NDArray[np.float64]


class Room(NamedTuple):
    """Arrays of the derivatives; N inputs: strains, rates, actuation, forces on points, moments on nodes.

    Attributes:
        rates0, rates1: motion at both ends for the rates there. spin0, spin1: of the nodes' own turns for q1 - q0.
        by_q1: of the balance by q1, shape (n, n); by_input: of balance, then momentum, by the inputs, shape (n, N).
        curvature: second derivatives, then those of the momentum by q1, shape (n, n).
        lack: derivative of what the balance lacks by q1, shape (n,); row: by the inputs, shape (N,).
        force: shape (P, 3); moment: shape (K + 1, 3); torque: shape (K + 1,); turn: shape (3, n).
        by_force0, by_force1: of a point's force by q0 and q1, shape (3, n). q0, w0: before the step, shape (n,).
    """

    rates0: Rates
    rates1: Rates
    spin0: Array
    spin1: Array
    by_q1: Array
    by_input: Array
    curvature: Array
    lack: Array
    row: Array
    force: Array
    moment: Array
    torque: Array
    turn: Array
    by_force0: Array
    by_force1: Array
    q0: Array
    w0: Array


def room_for(layout: Layout, inputs: int) -> Room:
    """Return arrays for the derivatives of this robot's steps by `inputs` numbers, 2 n + m at least."""
    n, nodes, points = len(layout.component), len(layout.polar), len(layout.mass)
    room = Room(
        empty_rates(layout), empty_rates(layout), np.zeros((nodes, n)), np.zeros((nodes, n)), np.zeros((n, n)),
        np.zeros((n, inputs)), np.zeros((n, n)), np.zeros(n), np.zeros(inputs), np.zeros((points, 3)),
        np.zeros((nodes, 3)), np.zeros(nodes), np.zeros((3, n)), np.zeros((3, n)), np.zeros((3, n)), np.zeros(n),
        np.zeros(n),
    )  # fmt: skip
    return park(room)


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
def _points(layout: Layout, h: float, work: Scratch, room: Room) -> None:
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
def _tendons(layout: Layout, loads: Loads, work: Scratch, room: Room) -> None:
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


@inlined
def _add_half(into: Any, what: Any, n: int) -> None:
    for a in range(n):
        for b in range(n):
            into[a, b] += 0.5 * what[a, b]


@kernel
def _bend(layout: Layout, q: Any, shape: Any, paths: Any, work: Scratch, room: Room) -> None:
    """Write to `room.curvature` what forces, tensions and own moments do through second derivatives."""
    room.curvature[:, :] = 0.0
    room.moment[:, :] = 0.0
    add_curvature(layout, q, shape, work.force, room.moment, work.torque, room.curvature)
    if len(work.taut) > 0:
        add_tendon_stiffness(layout, q, work.taut, 1.0, paths, room.curvature)


@kernel
def _turn(layout: Layout, loads: Loads, q: Any, shape: Any, room: Room) -> bool:
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


@kernel
def differentiate(
    layout: Layout,
    loads: Loads,
    q0: Any,
    w0: Any,
    q1: Any,
    w1: Any,
    h: float,
    points: Any,
    nodes: Any,
    work: Scratch,
    room: Room,
    out: Any,
) -> bool:
    """Write d(q1, w1) / d(q0, w0, actuation, forces, moments) of the step of length h that `work` has just taken.

    Args:
        layout: of the robot.
        loads: held over the step.
        q0: strains before the step, shape (n,).
        w0: their rates [1/s], shape (n,).
        q1: strains after the step, shape (n,).
        w1: their rates [1/s], shape (n,).
        h: [s].
        points: mass points on which forces act, shape (f,); nodes: on which moments do, shape (g,); dead, world frame.
        work: what the step left there.
        room: of the derivatives, for N = 2 n + m + 3 f + 3 g inputs.
        out: shape (2 n, N).

    Returns:
        False where the step's matrix is singular.
    """
    n, m = len(q1), len(layout.straight)
    one, two = work.before, work.after
    r1, rx, lack, row, change, pull = room.by_q1, room.by_input, room.lack, room.row, work.change, work.pull
    find_rates(layout, q0, w0, one, room.rates0)
    find_rates(layout, q1, w1, two, room.rates1)
    find_spins(layout, q0, change, one, room.turn, room.spin0)
    find_spins(layout, q1, change, two, room.turn, room.spin1)
    inputs = len(row)
    row[:], lack[:] = 0.0, 0.0
    rx[:, :], r1[:, :] = 0.0, 0.0
    _points(layout, h, work, room)
    _tendons(layout, loads, work, room)
    _bend(layout, q0, one, work.paths_before, work, room)
    _add_half(rx, room.curvature, n)
    _bend(layout, q1, two, work.paths_after, work, room)
    _add_half(r1, room.curvature, n)
    for k in range(1, len(layout.polar)):  # their share is in the balance, but not in what it lacks
        for b in range(n):
            lack[b] += 0.5 * work.torque[k] * room.spin1[k, b]
            row[b] += 0.5 * work.torque[k] * room.spin0[k, b]
    column = 2 * n + m
    for j in points:
        for i in range(3):
            row[column] -= two.point[j, i] - one.point[j, i]
            for a in range(layout.last[layout.place[j] - 1]):
                rx[a, column] -= 0.5 * (one.jacobian[j, i, a] + two.jacobian[j, i, a])
            column += 1
    for a in range(n):
        for b in range(inputs):
            row[b] -= change[a] * rx[a, b]
        for b in range(n):
            lack[b] -= change[a] * r1[a, b]
    share, norm = work.unit[1], work.unit[2]
    for a in range(n):
        slope = pull[a] + 2.0 * share * layout.stiffness[a, a] * change[a]
        lack[a] -= slope
        row[a] += slope
    for k in nodes:  # dead moments do no work that the balance counts
        for i in range(3):
            for a in range(n):
                rx[a, column] -= 0.5 * (one.twist[k, i, a] + two.twist[k, i, a])
            column += 1
    for k in range(1, len(layout.polar)):
        if layout.polar[k] == 0.0:
            continue
        last, factor = layout.last[k - 1], 2.0 * layout.polar[k] / h
        for a in range(last):
            left = 0.5 * factor * (one.spin[k, a] + two.spin[k, a])
            for b in range(last):
                mean = 0.5 * (one.spin[k, b] + two.spin[k, b])
                r1[a, b] += left / h * (mean + 0.5 * room.spin1[k, b])
                rx[a, b] += left * ((0.5 * room.spin0[k, b] - mean) / h - room.rates0.spin[k, b])
                rx[a, n + b] -= left * one.spin[k, b]
    for a in range(n):
        weight = layout.stiffness[a, a]
        along = weight * change[a] / norm
        for b in range(inputs):
            rx[a, b] += along * row[b]
        for b in range(n):
            r1[a, b] += work.elastic[a, b] + along * lack[b]
            rx[a, b] += layout.stiffness[a, b] - work.elastic[a, b]
        r1[a, a] += share * weight
        rx[a, a] -= share * weight
    if _turn(layout, loads, q0, one, room):
        _add_half(rx, room.curvature, n)
        _turn(layout, loads, q1, two, room)
        _add_half(r1, room.curvature, n)
    if not factor_lu(r1, work.rows, n):
        return False
    for a in range(n):
        for b in range(inputs):
            out[a, b] = -rx[a, b]
    solve_lu_columns(r1, work.rows, out, n)
    done: bool = _momentum(layout, q1, w1, h, work, room, out)
    return done


@kernel
def _momentum(layout: Layout, q1: Any, w1: Any, h: float, work: Scratch, room: Room, out: Any) -> bool:
    """Write the derivatives of the rates after the step, from those of its strains."""
    n, inputs = len(w1), out.shape[1]
    one, two = work.before, work.after
    p1, px = room.curvature, room.by_input
    for j in range(len(layout.mass)):
        for i in range(3):
            moved = 0.0
            for a in range(layout.last[layout.place[j] - 1]):
                moved += two.jacobian[j, i, a] * w1[a]
            v = 2.0 * (two.point[j, i] - one.point[j, i]) / h - work.velocity[j, i]
            room.force[j, i] = layout.mass[j] * (v - moved)
    for k in range(1, len(layout.polar)):
        turned = moved = 0.0
        for a in range(layout.last[k - 1]):
            turned += 0.5 * (one.spin[k, a] + two.spin[k, a]) * work.change[a]
            moved += two.spin[k, a] * w1[a]
        room.torque[k] = layout.polar[k] * (2.0 * turned / h - work.spin[k] - moved)
    room.moment[:, :] = 0.0
    p1[:, :], px[:, :] = 0.0, 0.0
    add_curvature(layout, q1, two, room.force, room.moment, room.torque, p1)
    for j in range(len(layout.mass)):
        last = layout.last[layout.place[j] - 1]
        for i in range(3):
            for a in range(last):
                left = layout.mass[j] * two.jacobian[j, i, a]
                for b in range(last):
                    p1[a, b] += left * (2.0 / h * two.jacobian[j, i, b] - room.rates1.point[j, i, b])
                for b in range(last):
                    px[a, b] -= left * (2.0 / h * one.jacobian[j, i, b] + room.rates0.point[j, i, b])
                for b in range(last):
                    px[a, n + b] -= left * one.jacobian[j, i, b]
    for k in range(1, len(layout.polar)):
        if layout.polar[k] == 0.0:
            continue
        last = layout.last[k - 1]
        for a in range(last):
            left = layout.polar[k] * two.spin[k, a]
            for b in range(last):
                mean = one.spin[k, b] + two.spin[k, b]
                p1[a, b] += left * ((mean + room.spin1[k, b]) / h - room.rates1.spin[k, b])
                px[a, b] += left * ((room.spin0[k, b] - mean) / h - room.rates0.spin[k, b])
                px[a, n + b] -= left * one.spin[k, b]
    mass_matrix(layout, two, work.matrix)
    if not factor_symmetric(work.matrix, n):
        return False
    for a in range(n):
        for b in range(inputs):
            out[n + a, b] = px[a, b]
        for c in range(n):
            factor = p1[a, c]
            for b in range(inputs):
                out[n + a, b] += factor * out[c, b]
    solve_symmetric_columns(work.matrix, out, n, n)
    return True
