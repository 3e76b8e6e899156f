"""Derivatives of one step of the strain rod by state, actuation and loads: its balance, differentiated.

With the balance R(q1; q0, w0, inputs) = 0 of a step and the rates w1 after it, M(q1) w1 = p(q0, w0, q1),

    dq1 = -R_q1^-1 R_x dx,    M dw1 = (p_q1 - (M w1)_q1) dq1 + p_x dx.

All terms are exact for the discrete rod, the balance's share and the derivatives of the Jacobians among them.
"""

from typing import Any

from tendond.model.numerics.compile import inlined, kernel
from tendond.model.numerics.linear import factor_lu
from tendond.model.strain.derivatives.columns import solve_lu_columns
from tendond.model.strain.derivatives.forces import add_points, add_pulls, bend, turn
from tendond.model.strain.derivatives.momentum import find_momentum
from tendond.model.strain.derivatives.rates import find_rates
from tendond.model.strain.derivatives.room import Room
from tendond.model.strain.derivatives.spins import find_spins
from tendond.model.strain.layout import Layout
from tendond.model.strain.stepping.scratch import Loads, Scratch


@inlined
def _add_half(into: Any, what: Any, n: int) -> None:
    for a in range(n):
        for b in range(n):
            into[a, b] += 0.5 * what[a, b]


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
    add_points(layout, h, work, room)
    add_pulls(layout, loads, work, room)
    bend(layout, q0, one, work.paths_before, work, room)
    _add_half(rx, room.curvature, n)
    bend(layout, q1, two, work.paths_after, work, room)
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
    if turn(layout, loads, q0, one, room):
        _add_half(rx, room.curvature, n)
        turn(layout, loads, q1, two, room)
        _add_half(r1, room.curvature, n)
    if not factor_lu(r1, work.rows, n):
        return False
    for a in range(n):
        for b in range(inputs):
            out[a, b] = -rx[a, b]
    solve_lu_columns(r1, work.rows, out, n)
    done: bool = find_momentum(layout, q1, w1, h, work, room, out)
    return done
