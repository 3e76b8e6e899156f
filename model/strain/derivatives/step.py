"""Derivatives of one step of the strain rod by state, actuation and loads: its balance, differentiated.

With the balance R(q1; q0, w0, inputs) = 0 of a step and the rates w1 after it, M(q1) w1 = p(q0, w0, q1),

    dq1 = -R_q1^-1 R_x dx,    M dw1 = (p_q1 - (M w1)_q1) dq1 + p_x dx.

All terms are exact for the discrete rod, the balance's share and the derivatives of the Jacobians among them.
"""

from typing import Any

from tendond.model.numerics.columns import solve_lu_columns
from tendond.model.numerics.compile import lean
from tendond.model.numerics.elimination import factor_lu
from tendond.model.numerics.products import padded
from tendond.model.strain.derivatives.forces import add_bend, add_pulls, add_turn
from tendond.model.strain.derivatives.inertia_rows import write_nodes, write_points
from tendond.model.strain.derivatives.momentum import find_momentum
from tendond.model.strain.derivatives.rates import find_rates
from tendond.model.strain.derivatives.room import Room
from tendond.model.strain.derivatives.rows import add_all_nodes, add_all_points
from tendond.model.strain.derivatives.spins import find_spins
from tendond.model.strain.layout import Layout
from tendond.model.strain.stepping.scratch import Loads, Scratch


@lean
def _find_lack(layout: Layout, work: Scratch, room: Room) -> None:
    """Write what the balance lacks by q1, and by all inputs but moments, which do no work that it counts."""
    n, width = len(work.q1), padded(len(work.q1))
    columns = len(room.by_input) // n
    one, two, lack, row, change = work.before, work.after, room.lack, room.row, work.change
    for b in range(n):
        row[b] += room.early[b]
        row[n + b] += room.early[width + b]
    for k in range(1, len(layout.polar)):  # their share is in the balance, but not in what it lacks
        for b in range(n):
            lack[b] += 0.5 * work.torque[k] * room.spin1[k, b]
            row[b] += 0.5 * work.torque[k] * room.spin0[k, b]
    column = 2 * n + len(layout.straight)
    for j in room.points:
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
    layout: Layout, loads: Loads, q0: Any, w0: Any, h: float, known: bool, work: Scratch, room: Room, out: Any
) -> bool:
    """Write d(q1, w1) / d(q0, w0, actuation, forces, moments) of the step of length h that `work` has just taken.

    Args:
        layout: of the robot.
        loads: held over the step.
        q0: strains before the step, shape (n,).
        w0: their rates [1/s], shape (n,).
        h: [s].
        known: whether `room.rates0` is at (q0, w0) already, as the `rates1` of the step that led here: see `mirrored`.
        work: what the step left there, strains and rates after it among them.
        room: of the derivatives, for N = 2 n + m + 3 f + 3 g inputs.
        out: shape (2 n, N).

    Returns:
        False where the step's matrix is singular.
    """
    n, m, width, inputs = len(q0), len(layout.straight), padded(len(q0)), len(room.row)
    columns = len(room.by_input) // n
    one, two, rx, change = work.before, work.after, room.by_input, work.change
    if not known:
        find_rates(layout, w0, one, room.bends, room.rates0)
    find_rates(layout, work.w1, two, room.bends, room.rates1)
    find_spins(layout, change, one, room.bends, room.turn, room.spins0)
    find_spins(layout, change, two, room.bends, room.turn, room.spins1)
    room.early[:] = 0.0
    room.row[:], room.lack[:], rx[:] = 0.0, 0.0, 0.0
    room.by_q1[:], room.by_q0[:], room.by_w0[:] = 0.0, 0.0, 0.0
    write_points(layout, h, work, room)
    add_all_points(layout, room)
    add_pulls(layout, loads, work, room)
    add_bend(layout, one, work.paths_before, work, room, room.by_q0)
    add_bend(layout, two, work.paths_after, work, room, room.by_q1)
    _find_lack(layout, work, room)
    write_nodes(layout, h, work, room)
    add_all_nodes(layout, room)
    add_turn(layout, loads, one, room, room.by_q0)
    add_turn(layout, loads, two, room, room.by_q1)
    column = 2 * n + m + 3 * len(room.points)
    for k in room.nodes:
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
    find_momentum(layout, h, work, room)
    for a in range(n):
        for b in range(inputs):
            out[a, b], out[n + a, b] = rx[a * columns + b], room.turned[a * columns + b]
    return True
