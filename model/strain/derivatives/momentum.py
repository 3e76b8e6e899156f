"""Derivatives of the rates after a step, from those of its strains."""

from typing import Any

from tendond.model.numerics.compile import kernel
from tendond.model.numerics.linear import factor_symmetric
from tendond.model.strain.derivatives.columns import solve_symmetric_columns
from tendond.model.strain.derivatives.curvature import add_curvature
from tendond.model.strain.derivatives.room import Room
from tendond.model.strain.layout import Layout
from tendond.model.strain.stepping.mass import mass_matrix
from tendond.model.strain.stepping.scratch import Scratch


@kernel
def find_momentum(layout: Layout, q1: Any, w1: Any, h: float, work: Scratch, room: Room, out: Any) -> bool:
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
