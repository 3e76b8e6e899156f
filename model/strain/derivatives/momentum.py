"""Derivatives of the rates after a step, from those of its strains."""

from typing import Any

from tendond.model.numerics.compile import lean
from tendond.model.numerics.elimination import solve_symmetric_columns
from tendond.model.numerics.products import add_transformed, padded
from tendond.model.strain.derivatives.curvature import add_curvature
from tendond.model.strain.derivatives.room import Room
from tendond.model.strain.derivatives.rows import add_all_nodes, add_all_points
from tendond.model.strain.layout import Layout
from tendond.model.strain.stepping.scratch import Scratch


@lean
def _write_rows(layout: Layout, h: float, work: Scratch, room: Room) -> None:
    """Write the rows of the momentum: of mass points, then of the nodes' own turns."""
    width = padded(len(room.lack))
    left, after, before, rate = room.left, room.after, room.before, room.rate
    one, two = work.before, work.after
    for j in range(len(layout.mass)):
        for i in range(3):
            at = (3 * j + i) * width
            for b in range(layout.last[layout.place[j] - 1]):
                j0, j1 = one.jacobian[j, i, b], two.jacobian[j, i, b]
                left[at + b] = layout.mass[j] * j1
                after[at + b] = 2.0 / h * j1 - room.rates1.point[j, i, b]
                before[at + b] = -(2.0 / h * j0 + room.rates0.point[j, i, b])
                rate[at + b] = -j0
    for k in range(1, len(layout.polar)):
        at = (3 * len(layout.mass) + k - 1) * width
        for b in range(layout.last[k - 1]):
            both = one.spin[k, b] + two.spin[k, b]
            left[at + b] = layout.polar[k] * two.spin[k, b]
            after[at + b] = (both + room.spin1[k, b]) / h - room.rates1.spin[k, b]
            before[at + b] = (room.spin0[k, b] - both) / h - room.rates0.spin[k, b]
            rate[at + b] = -one.spin[k, b]


@lean
def find_momentum(layout: Layout, q1: Any, w1: Any, h: float, work: Scratch, room: Room) -> None:
    """Write to `room.turned` the derivatives of the rates after the step, from those of its strains."""
    n, width = len(w1), padded(len(w1))
    columns = len(room.by_input) // n
    one, two = work.before, work.after
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
    room.curvature[:, :] = 0.0
    add_curvature(layout, q1, two, room.force, room.moment, room.torque, room.bends, room.curvature)
    _write_rows(layout, h, work, room)
    room.by_q1[:], room.by_q0[:], room.by_w0[:] = 0.0, 0.0, 0.0
    add_all_points(layout, room)
    add_all_nodes(layout, room)
    room.turned[:] = 0.0
    for a in range(n):
        for b in range(n):
            room.by_q1[a * width + b] += room.curvature[a, b]
            room.turned[a * columns + b] = room.by_q0[a * width + b]
            room.turned[a * columns + n + b] = room.by_w0[a * width + b]
    add_transformed(room.by_q1, room.by_input, n, width, columns, room.turned)
    solve_symmetric_columns(work.mass, room.turned, n, width, columns)
