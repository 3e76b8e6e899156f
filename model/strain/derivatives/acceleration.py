"""Accelerations of the strain rod at a state, as affine functions of the tensions: M q'' = f(q, w) + sum T_i d'_i.

The balance of a step as its length goes to 0: M is the mass matrix, f holds inertia J' m (dJ/dt w), elasticity,
damping, drag, gravity and dead loads.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.columns import solve_symmetric_columns
from tendond.model.numerics.compile import lean
from tendond.model.numerics.elimination import factor_symmetric
from tendond.model.numerics.products import padded
from tendond.model.strain.derivatives.rates import find_rates
from tendond.model.strain.derivatives.room import Room
from tendond.model.strain.kinematics import find_shape
from tendond.model.strain.layout import Layout
from tendond.model.strain.second_derivatives.curvature import add_curvature
from tendond.model.strain.stepping.mass import find_mass
from tendond.model.strain.stepping.scratch import Loads, Scratch
from tendond.model.strain.tendon_stiffness import add_tendon_stiffness
from tendond.model.strain.tendons import find_paths

Array = NDArray[np.float64]


@lean
def accelerate(layout: Layout, loads: Loads, q: Any, w: Any, work: Scratch, room: Room, out: Any) -> bool:
    """Write M^-1 f to the first column of `out`, M^-1 d'_i to the others, padded rows; `work.taut`: tensions.

    `work.after` and `room.rates1` are then shape and motion at (q, w).

    Returns:
        False where the mass matrix is singular.
    """
    n, width = len(q), padded(len(q))
    columns = len(out) // n
    shape, rates, force = work.after, room.rates1, room.force
    find_shape(layout, q, shape)
    find_rates(layout, w, shape, room.bends, rates)
    if len(work.taut) > 0:
        find_paths(layout, q, work.paths_after)
    for a in range(n):
        value = 0.0
        for b in range(n):
            value -= layout.stiffness[a, b] * q[b] + layout.damping[a, b] * w[b]
        out[a * columns] = value
    for i in range(len(work.taut)):
        work.taut[i] = loads.tension[i]
        if loads.driven[i]:
            stretch = max(0.0, loads.tension[i] - work.paths_after.displacement[i])
            work.taut[i] = layout.tendon_stiffness[i] * stretch
        for a in range(n):
            out[a * columns + 1 + i] = work.paths_after.gradient[i, a]
    for j in range(len(layout.mass)):
        k, m = layout.place[j], layout.mass[j]
        last = layout.last[k - 1]
        for i in range(3):
            turned = 0.0
            for a in range(last):
                turned += rates.point[j, i, a] * w[a]
            force[j, i] = loads.force[j, i] + m * (layout.gravity[i] - turned)
        for c in range(3):
            if layout.drag[j, c] != 0.0:
                speed = 0.0
                for i in range(3):
                    for a in range(last):
                        speed += shape.rotation[k, 3 * i + c] * shape.jacobian[j, i, a] * w[a]
                for i in range(3):
                    force[j, i] -= layout.drag[j, c] * speed * abs(speed) * shape.rotation[k, 3 * i + c]
        for i in range(3):
            for a in range(last):
                out[a * columns] += force[j, i] * shape.jacobian[j, i, a]
    for k in range(1, len(layout.polar)):
        turned = 0.0
        for a in range(n):
            turned += rates.spin[k, a] * w[a]
        for a in range(n):
            out[a * columns] -= layout.polar[k] * turned * shape.spin[k, a]
            for i in range(3):
                out[a * columns] += loads.moment[k, i] * shape.twist[k, i, a]
    find_mass(layout, shape, work)
    if not factor_symmetric(work.mass, n, width):
        return False
    solve_symmetric_columns(work.mass, out, n, width, columns)
    return True


@lean
def tangent_stiffness(layout: Layout, loads: Loads, q: Any, work: Scratch, room: Room, out: Any) -> None:
    """Write the derivative of the forces' imbalance by q in statics, exact, shape (n, n); symmetric without moments.

    `work.after`, `work.paths_after` and `work.taut` are then those at q.
    """
    n = len(q)
    find_shape(layout, q, work.after)
    if len(work.taut) > 0:
        find_paths(layout, q, work.paths_after)
    for a in range(n):
        for b in range(n):
            out[a, b] = layout.stiffness[a, b]
    for j in range(len(layout.mass)):
        for i in range(3):
            room.force[j, i] = -layout.mass[j] * layout.gravity[i] - loads.force[j, i]
    for k in range(len(layout.polar)):
        room.torque[k] = 0.0
        for i in range(3):
            room.moment[k, i] = -loads.moment[k, i]
    add_curvature(layout, work.after, room.force, room.moment, room.torque, room.bends, out)
    for i in range(len(work.taut)):
        work.taut[i] = loads.tension[i]
        if loads.driven[i]:
            k = layout.tendon_stiffness[i]
            stretch = max(0.0, loads.tension[i] - work.paths_after.displacement[i])
            work.taut[i] = k * stretch
            if stretch > 0.0:
                for a in range(n):
                    for b in range(n):
                        out[a, b] += k * work.paths_after.gradient[i, a] * work.paths_after.gradient[i, b]
    if len(work.taut) > 0:
        add_tendon_stiffness(work.taut, work.paths_after, out)
