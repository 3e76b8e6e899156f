"""The energy whose minima are equilibria, and steps of implicit Euler's method, with its gradient.

V(q) = q' K q / 2 - sum f . x(q) - sum of the tendons' work, for dead forces.

An implicit Euler step of length h from q0 at the rates w0 is a minimum as well, of

    V(q) + sum m |x(q) - x0 - h v0|^2 / (2 h^2) + (q - q0)' D (q - q0) / (2 h) + drag's potential,

with moments as they act at q0. V is bounded below by a quadratic function, so there always is one (T. F. Gast, C.
Schroeder, A. Stomakhin, C. Jiang, J. M. Teran, "Optimization integrator for large time steps", IEEE TVCG 21, 2015).
"""

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import lean
from tendond.model.strain.kinematics import find_shape
from tendond.model.strain.layout import Layout
from tendond.model.strain.stepping.carried import TURN, carried_spin, is_moving
from tendond.model.strain.stepping.scratch import Loads, Scratch
from tendond.model.strain.tendons import find_paths

Array = NDArray[np.float64]


@lean
def find_energy(layout: Layout, loads: Loads, q: Array, rate: float, work: Scratch) -> tuple[float, float]:
    """Write the gradient of the energy at q to `work.residual`; return the energy, and its terms' sum of sizes [J].

    Args:
        layout: of the robot.
        loads: on it.
        q: strains, shape (n,).
        rate: 1 / h of an implicit Euler step [1/s], after `begin_step`; 0: statics.
        work: scratch arrays.
    """
    n = len(q)
    find_shape(layout, q, work.after)
    if len(work.taut) > 0:
        find_paths(layout, q, work.paths_after)
    residual, change, one, two = work.residual, work.change, work.before, work.after
    energy = size = 0.0
    moving = is_moving(work)
    for a in range(n):
        residual[a] = 0.0
        change[a] = q[a] - work.q0[a]
    for b in range(n):
        for a in range(n):
            residual[a] += layout.stiffness[b, a] * q[b]
    for a in range(n):
        energy += 0.5 * residual[a] * q[a]
    size = energy
    for i in range(len(work.taut)):
        if loads.driven[i]:
            stretch = max(0.0, loads.tension[i] - work.paths_after.displacement[i])
            work.taut[i] = layout.tendon_stiffness[i] * stretch
            part = 0.5 * layout.tendon_stiffness[i] * stretch * stretch
        else:
            work.taut[i] = loads.tension[i]
            part = -loads.tension[i] * work.paths_after.displacement[i]
        energy += part
        size += work.taut[i] * layout.straight[i]  # a displacement is the small difference of two lengths
        if work.taut[i] != 0.0:
            for a in range(n):
                residual[a] -= work.taut[i] * work.paths_after.gradient[i, a]
    for j in range(len(layout.mass)):
        m, k = layout.mass[j], layout.place[j]
        px, py, pz = two.point[j, 0], two.point[j, 1], two.point[j, 2]
        fx = -m * layout.gravity[0] - loads.force[j, 0]
        fy = -m * layout.gravity[1] - loads.force[j, 1]
        fz = -m * layout.gravity[2] - loads.force[j, 2]
        part = fx * px + fy * py + fz * pz
        energy += part
        size += abs(part)
        if rate > 0.0:
            x, y, z = rate * (px - one.point[j, 0]), rate * (py - one.point[j, 1]), rate * (pz - one.point[j, 2])
            vx, vy, vz = x - work.velocity[j, 0], y - work.velocity[j, 1], z - work.velocity[j, 2]
            part = 0.5 * m * (vx * vx + vy * vy + vz * vz)
            fx += m * rate * vx
            fy += m * rate * vy
            fz += m * rate * vz
            for c in range(3):
                if layout.drag[j, c] != 0.0:
                    rx, ry, rz = one.rotation[k, c], one.rotation[k, 3 + c], one.rotation[k, 6 + c]
                    speed = rx * x + ry * y + rz * z
                    drag = layout.drag[j, c] * speed * abs(speed)
                    part += drag * speed / (3.0 * rate)
                    fx += drag * rx
                    fy += drag * ry
                    fz += drag * rz
            energy += part
            size += part
        work.force[j, 0], work.force[j, 1], work.force[j, 2] = fx, fy, fz
        for a in range(layout.last[k - 1]):
            residual[a] += fx * two.jacobian[j, 0, a] + fy * two.jacobian[j, 1, a] + fz * two.jacobian[j, 2, a]
    for k in range(1, len(layout.polar)):
        last = layout.last[k - 1]
        if rate > 0.0 and layout.polar[k] != 0.0:
            turned = 0.0
            for a in range(last):
                turned += one.spin[k, a] * change[a]
            if moving:
                turned += carried_spin(work, one, TURN, k)
            turned = rate * turned - work.spin[k]
            part = 0.5 * layout.polar[k] * turned * turned
            energy += part
            size += part
            for a in range(last):
                residual[a] += layout.polar[k] * rate * turned * one.spin[k, a]
        x, y, z = loads.moment[k, 0], loads.moment[k, 1], loads.moment[k, 2]
        if x != 0.0 or y != 0.0 or z != 0.0:
            twist = one.twist if rate > 0.0 else two.twist
            for a in range(last):
                push = x * twist[k, 0, a] + y * twist[k, 1, a] + z * twist[k, 2, a]
                residual[a] -= push
                if rate > 0.0:
                    energy -= push * change[a]
                    size += abs(push * change[a])
    if rate > 0.0:
        for b in range(n):
            left = rate * change[b]
            part = 0.0
            for a in range(n):
                residual[a] += layout.damping[b, a] * left
                part += 0.5 * layout.damping[b, a] * left * change[a]
            energy += part
            size += part
    return energy, size
