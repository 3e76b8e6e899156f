"""Derivatives of one step of the strain rod by state, actuation and loads: its balance, differentiated.

With the balance R(q1; q0, w0, inputs) = 0 of a step and the rates w1 after it, M(q1) w1 = p(q0, w0, q1),

    dq1 = -R_q1^-1 R_x dx,    M dw1 = (p_q1 - (M w1)_q1) dq1 + p_x dx.

All terms are exact for the discrete rod, the balance's share and the derivatives of the Jacobians among them.
"""

from typing import Any

from tendond.model.numerics.compile import lean
from tendond.model.numerics.elimination import factor_lu, solve_lu_columns
from tendond.model.numerics.products import padded
from tendond.model.strain.derivatives.forces import add_bend, add_pulls, add_turn, write_points
from tendond.model.strain.derivatives.momentum import find_momentum
from tendond.model.strain.derivatives.rates import find_rates
from tendond.model.strain.derivatives.room import Room
from tendond.model.strain.derivatives.rows import add_all_nodes, add_all_points
from tendond.model.strain.derivatives.spins import find_spins
from tendond.model.strain.layout import Layout
from tendond.model.strain.stepping.scratch import Loads, Scratch


@lean
def _write_nodes(layout: Layout, h: float, work: Scratch, room: Room) -> None:
    """Write the rows of the nodes' inertia about their own axes."""
    width = padded(len(room.lack))
    one, two = work.before, work.after
    for k in range(1, len(layout.polar)):
        factor, at = layout.polar[k] / h, (3 * len(layout.mass) + k - 1) * width
        for b in range(layout.last[k - 1]):
            both = one.spin[k, b] + two.spin[k, b]
            room.left[at + b] = factor * both
            room.after[at + b] = 0.5 * (both + room.spin1[k, b]) / h
            room.before[at + b] = 0.5 * (room.spin0[k, b] - both) / h - room.rates0.spin[k, b]
            room.rate[at + b] = -one.spin[k, b]


@lean
def _find_lack(layout: Layout, points: Any, work: Scratch, room: Room) -> None:
    """Write what the balance lacks by q1, and by all inputs but moments, which do no work that it counts."""
    n, width = len(room.lack), padded(len(room.lack))
    columns = len(room.by_input) // n
    one, two, lack, row, change = work.before, work.after, room.lack, room.row, work.change
    for k in range(1, len(layout.polar)):  # their share is in the balance, but not in what it lacks
        for b in range(n):
            lack[b] += 0.5 * work.torque[k] * room.spin1[k, b]
            row[b] += 0.5 * work.torque[k] * room.spin0[k, b]
    column = 2 * n + len(layout.straight)
    for j in points:
        for i in range(3):
            row[column] -= two.point[j, i] - one.point[j, i]
            for a in range(layout.last[layout.place[j] - 1]):
                room.by_input[a * columns + column] = -0.5 * (one.jacobian[j, i, a] + two.jacobian[j, i, a])
            column += 1
    share = work.unit[1]
    for a in range(n):
        for b in range(n):
            lack[b] -= change[a] * room.by_q1[a * width + b]
            row[b] -= change[a] * room.by_q0[a * width + b]
            row[n + b] -= change[a] * room.by_w0[a * width + b]
        for b in range(2 * n, column):
            row[b] -= change[a] * room.by_input[a * columns + b]
    for a in range(n):
        slope = work.pull[a] + 2.0 * share * layout.stiffness[a, a] * change[a]
        lack[a] -= slope
        row[a] += slope


@lean
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
    n, m, width, inputs = len(q1), len(layout.straight), padded(len(q1)), len(room.row)
    columns = len(room.by_input) // n
    one, two, rx, change = work.before, work.after, room.by_input, work.change
    find_rates(layout, q0, w0, one, room.bends, room.rates0)
    find_rates(layout, q1, w1, two, room.bends, room.rates1)
    find_spins(layout, q0, change, one, room.bends, room.turn, room.spins0)
    find_spins(layout, q1, change, two, room.bends, room.turn, room.spins1)
    room.row[:], room.lack[:], rx[:] = 0.0, 0.0, 0.0
    room.by_q1[:], room.by_q0[:], room.by_w0[:] = 0.0, 0.0, 0.0
    write_points(layout, h, work, room)
    add_all_points(layout, room)
    add_pulls(layout, loads, work, room)
    add_bend(layout, q0, one, work.paths_before, work, room, room.by_q0)
    add_bend(layout, q1, two, work.paths_after, work, room, room.by_q1)
    _find_lack(layout, points, work, room)
    _write_nodes(layout, h, work, room)
    add_all_nodes(layout, room)
    add_turn(layout, loads, q0, one, room, room.by_q0)
    add_turn(layout, loads, q1, two, room, room.by_q1)
    column = 2 * n + m + 3 * len(points)
    for k in nodes:
        for i in range(3):
            for a in range(n):
                rx[a * columns + column] = -0.5 * (one.twist[k, i, a] + two.twist[k, i, a])
            column += 1
    share, norm = work.unit[1], work.unit[2]
    for a in range(n):
        weight = layout.stiffness[a, a]
        along = weight * change[a] / norm
        for b in range(n):
            elastic = work.elastic[a, b]
            room.by_q1[a * width + b] += elastic + along * room.lack[b]
            rx[a * columns + b] = elastic - layout.stiffness[a, b] - room.by_q0[a * width + b] - along * room.row[b]
            rx[a * columns + n + b] = -room.by_w0[a * width + b] - along * room.row[n + b]
        for b in range(2 * n, inputs):
            rx[a * columns + b] = -rx[a * columns + b] - along * room.row[b]
        room.by_q1[a * width + a] += share * weight
        rx[a * columns + a] += share * weight
    if not factor_lu(room.by_q1, work.rows, n, width, work.solving):
        return False
    solve_lu_columns(room.by_q1, work.rows, rx, n, width, columns)
    find_momentum(layout, q1, w1, h, work, room)
    for a in range(n):
        for b in range(inputs):
            out[a, b], out[n + a, b] = rx[a * columns + b], room.turned[a * columns + b]
    return True
