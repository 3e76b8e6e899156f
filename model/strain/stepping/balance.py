"""The balance of one time step of the strain rod: an energy-consistent mean of both ends.

With the modes q, their rates w and the mass points x(q), a step of length h from (q0, w0) solves for q1

    J' m ((x1 - x0) 2/h^2 - J0 w0 2/h) + K (q0 + q1) / 2 + e K (q1 - q0) + D (q1 - q0) / h = J' f + sum T_i d'_i,

J = (J0 + J1) / 2, d' likewise, with a share of q1 - q0 that makes J (q1 - q0) = x1 - x0 in the work of the forces: a
discrete gradient (O. Gonzalez, "Time integration and discrete Hamiltonian systems", J. Nonlinear Sci. 6, 1996).
Kinetic, elastic and gravity's energy then change by what the loads do, less what D and e dissipate, whatever the step:
nothing grows by itself, however light the damping. The load is held over the step, without a lag. `e` is what keeps the
fastest modes from ringing.
"""

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, lean
from tendond.model.strain.friction.pulls import add_friction
from tendond.model.strain.kinematics import find_shape, point_of
from tendond.model.strain.layout import Layout
from tendond.model.strain.stepping.carried import BEFORE, TURN, carried_spin, carried_velocity, is_moving, own_move
from tendond.model.strain.stepping.scratch import Loads, Scratch
from tendond.model.strain.tendons import find_paths

Array = NDArray[np.float64]

DISSIPATION = 0.02
"""e: numerical damping of the modes that a step does not resolve, as a part of K over one step. It is a
damping D = e h K: a damping ratio of e h w / 2 for a mode of frequency w. Chosen; `pytest
tests/unit/strain/test_dynamics.py` has motions that are right at 10 ms with it, and no step that fails."""

STILL = 1e-6
"""Change in the measure of energy below which there is no balance to keep [rad]: what it lacks is lost in rounding."""


@lean
def begin_step(layout: Layout, q0: Array, w0: Array, h: float, work: Scratch) -> None:
    """Write what a step of length h from (q0, w0) holds: `work.before` and its paths are at q0 already."""
    n = len(q0)
    jacobian, spin, moving = work.before.jacobian, work.before.spin, is_moving(work)
    for j in range(len(layout.mass)):
        x = y = z = 0.0
        for a in range(layout.last[layout.place[j] - 1]):
            x += jacobian[j, 0, a] * w0[a]
            y += jacobian[j, 1, a] * w0[a]
            z += jacobian[j, 2, a] * w0[a]
        if moving:
            dx, dy, dz = carried_velocity(work, work.before, BEFORE, point_of(work.before.point, j))
            x, y, z = x + dx, y + dy, z + dz
        work.velocity[j, 0], work.velocity[j, 1], work.velocity[j, 2] = x, y, z
    for k in range(1, len(layout.polar)):
        rate = 0.0
        for a in range(layout.last[k - 1]):
            rate += spin[k, a] * w0[a]
        work.spin[k] = rate + carried_spin(work, work.before, BEFORE + 3, k) if moving else rate
    for a in range(n):
        work.held[a] = 0.0
    for b in range(n):
        for a in range(n):
            work.elastic[b, a] = (0.5 + DISSIPATION) * layout.stiffness[b, a] + layout.damping[b, a] / h
            work.held[a] += layout.stiffness[b, a] * q0[b]


@inlined
def _find_tensions(layout: Layout, loads: Loads, work: Scratch) -> None:
    """Write the mean tension of each tendon over a step [N], the work of its spring per displacement, and its slope."""
    for i in range(len(work.taut)):
        if layout.friction[i] > 0.0:
            work.taut[i] = work.slack[i] = 0.0  # see `friction.pulls`
        elif loads.driven[i]:
            k = layout.tendon_stiffness[i]
            before = loads.tension[i] - work.paths_before.displacement[i]
            after = loads.tension[i] - work.paths_after.displacement[i]
            if before > 0.0 and after > 0.0:
                work.taut[i], work.slack[i] = 0.5 * k * (before + after), -0.5 * k
            elif before > 0.0:
                work.taut[i] = 0.5 * k * before * before / (before - after)
                work.slack[i] = -work.taut[i] / (before - after)
            elif after > 0.0:
                work.taut[i] = 0.5 * k * after * after / (after - before)
                work.slack[i] = -(k * after - work.taut[i]) / (after - before)
            else:
                work.taut[i] = work.slack[i] = 0.0
        else:
            work.taut[i], work.slack[i] = loads.tension[i], 0.0


@lean
def find_residual(layout: Layout, loads: Loads, q0: Array, q1: Array, h: float, work: Scratch) -> None:
    """Write the residual of a step that ends at q1, after `begin_step`."""
    n = len(q0)
    find_shape(layout, q1, work.after)
    if len(work.taut) > 0:
        find_paths(layout, q1, work.paths_after)
    _find_tensions(layout, loads, work)
    residual, change, pull = work.residual, work.change, work.pull
    one, two = work.before, work.after
    norm = lacking = 0.0
    moving = is_moving(work)
    for a in range(n):
        change[a] = q1[a] - q0[a]
        residual[a] = work.held[a]
        pull[a] = 0.0  # of all forces but the elastic ones
        norm += layout.stiffness[a, a] * change[a] * change[a]
    for b in range(n):
        for a in range(n):
            residual[a] += work.elastic[b, a] * change[b]
    for i in range(len(work.taut)):
        tension = 0.5 * work.taut[i]
        if tension != 0.0:
            lacking -= work.taut[i] * (work.paths_after.displacement[i] - work.paths_before.displacement[i])
            for a in range(n):
                pull[a] -= tension * (work.paths_before.gradient[i, a] + work.paths_after.gradient[i, a])
    for j in range(len(layout.mass)):
        m, k = layout.mass[j], layout.place[j]
        x, y, z = (
            (two.point[j, 0] - one.point[j, 0]),
            (two.point[j, 1] - one.point[j, 1]),
            (two.point[j, 2] - one.point[j, 2]),
        )
        factor = 2.0 * m / h
        fx = factor * (x / h - work.velocity[j, 0]) - m * layout.gravity[0] - loads.force[j, 0]
        fy = factor * (y / h - work.velocity[j, 1]) - m * layout.gravity[1] - loads.force[j, 1]
        fz = factor * (z / h - work.velocity[j, 2]) - m * layout.gravity[2] - loads.force[j, 2]
        for c in range(3):
            if layout.drag[j, c] != 0.0:
                rx = 0.5 * (one.rotation[k, c] + two.rotation[k, c])
                ry = 0.5 * (one.rotation[k, 3 + c] + two.rotation[k, 3 + c])
                rz = 0.5 * (one.rotation[k, 6 + c] + two.rotation[k, 6 + c])
                speed = (rx * x + ry * y + rz * z) / h
                drag = layout.drag[j, c] * speed * abs(speed)
                fx += drag * rx
                fy += drag * ry
                fz += drag * rz
        work.force[j, 0], work.force[j, 1], work.force[j, 2] = fx, fy, fz
        if moving:
            x, y, z = own_move(one, two, j)
        work.moved[j, 0], work.moved[j, 1], work.moved[j, 2] = x, y, z
        lacking += fx * x + fy * y + fz * z
        fx, fy, fz = 0.5 * fx, 0.5 * fy, 0.5 * fz
        for a in range(layout.last[k - 1]):
            pull[a] += (
                fx * (one.jacobian[j, 0, a] + two.jacobian[j, 0, a])
                + fy * (one.jacobian[j, 1, a] + two.jacobian[j, 1, a])
                + fz * (one.jacobian[j, 2, a] + two.jacobian[j, 2, a])
            )  # fmt: skip
    for a in range(n):
        residual[a] += pull[a]
        lacking -= pull[a] * change[a]
    for k in range(1, len(layout.polar)):
        last = layout.last[k - 1]
        if layout.polar[k] != 0.0:
            rate = 0.0
            for a in range(last):
                rate += (one.spin[k, a] + two.spin[k, a]) * change[a]
            if moving:
                rate += carried_spin(work, one, TURN, k) + carried_spin(work, two, TURN, k)
            torque = 2.0 * layout.polar[k] / h * (0.5 * rate / h - work.spin[k])
            work.torque[k] = torque
            for a in range(last):
                residual[a] += 0.5 * torque * (one.spin[k, a] + two.spin[k, a])
        x, y, z = 0.5 * loads.moment[k, 0], 0.5 * loads.moment[k, 1], 0.5 * loads.moment[k, 2]
        if x != 0.0 or y != 0.0 or z != 0.0:
            for a in range(last):
                residual[a] -= (
                    x * (one.twist[k, 0, a] + two.twist[k, 0, a]) + y * (one.twist[k, 1, a] + two.twist[k, 1, a])
                    + z * (one.twist[k, 2, a] + two.twist[k, 2, a])
                )  # fmt: skip
    norm += STILL * STILL * work.unit[0]
    share = lacking / norm
    for a in range(n):
        residual[a] += share * layout.stiffness[a, a] * change[a]
    work.unit[1], work.unit[2] = share, norm
    if len(work.grip.tendon) > 0:
        add_friction(layout, loads, q1, work)
