"""Derivatives of the rates after a step, from those of its strains."""

from tendond.model.numerics.columns import add_transformed, solve_symmetric_columns
from tendond.model.numerics.compile import lean
from tendond.model.numerics.products import padded
from tendond.model.numerics.vectors import cross
from tendond.model.strain.derivatives.inertia_rows import write_momenta, write_node_momenta
from tendond.model.strain.derivatives.room import Room
from tendond.model.strain.derivatives.rows import add_all_nodes, add_all_points
from tendond.model.strain.layout import Layout
from tendond.model.strain.second_derivatives.curvature import add_curvature
from tendond.model.strain.stepping.scratch import Scratch


@lean
def find_momentum(layout: Layout, h: float, work: Scratch, room: Room) -> None:
    """Write to `room.turned` the derivatives of the rates after the step, from those of its strains.

    After the balance, whose moments of inertia `work.torque` holds, with the motion after the step in `room.rates1`.
    """
    n, width = len(work.w1), padded(len(work.w1))
    columns = len(room.by_input) // n
    one, two = work.before, work.after
    node = room.rates1.node
    for j in range(len(layout.mass)):
        k = layout.place[j]
        x = two.point[j, 0], two.point[j, 1], two.point[j, 2]
        turn = cross((node[k, 0], node[k, 1], node[k, 2]), x)
        for i in range(3):
            v = 2.0 * (x[i] - one.point[j, i]) / h - work.velocity[j, i]
            room.force[j, i] = layout.mass[j] * (v - turn[i] - node[k, 3 + i])
    for k in range(1, len(layout.polar)):
        moved = 0.0
        for i in range(3):
            moved += two.rotation[k, 3 * i + 2] * node[k, i]
        room.torque[k] = h * work.torque[k] + layout.polar[k] * (work.spin[k] - moved)
    room.moment[:, :] = 0.0
    room.curvature[:, :] = 0.0
    add_curvature(layout, two, room.force, room.moment, room.torque, room.bends, room.curvature)
    write_momenta(layout, h, work, room)
    write_node_momenta(layout, h, work, room)
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
