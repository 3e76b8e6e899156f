"""Minima of the strain rod's energy: equilibria, and steps that always have a solution.

V(q) = q' K q / 2 - sum f . x(q) - sum of the tendons' work, for dead forces. A Newton method on V, damped in the metric
of the stiffness where it must (Levenberg and Marquardt), goes downhill from where it starts: a rod that is loaded
slowly gets to the same place, and what is found is stable. Dead moments are no gradient of any energy: with them, the
residual decides instead.

An implicit Euler step of length h from q0 at the rates w0 is a minimum as well, of

    V(q) + sum m |x(q) - x0 - h v0|^2 / (2 h^2) + (q - q0)' D (q - q0) / (2 h) + drag's potential,

with moments as they act at q0. V is bounded below by a quadratic function, so there always is one (T. F. Gast, C.
Schroeder, A. Stomakhin, C. Jiang, J. M. Teran, "Optimization integrator for large time steps", IEEE TVCG 21, 2015).
"""

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import lean
from tendond.model.numerics.linear import factor_symmetric, solve_symmetric
from tendond.model.strain.equations import Loads, Scratch
from tendond.model.strain.kinematics import curvature_of_points, find_shape
from tendond.model.strain.layout import Layout
from tendond.model.strain.tendons import add_tendon_stiffness, find_paths

Array = NDArray[np.float64]

ITERATIONS = 300

ROUNDING = 1e-14
"""Of the energies' sum, below which a decrease is lost in rounding."""

ATTAINED = 1e-12
"""Of the energies' sum: an undamped step promises less, where no step goes down any more and the minimum is reached."""

CONTRACTION = 0.05
"""Of the decrement in one step, above which a new second derivative is worth its price."""


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


@lean
def find_hessian(layout: Layout, loads: Loads, q: Array, rate: float, work: Scratch) -> None:
    """Write the second derivative of the energy at q to `work.hessian`, shape (n, n), after `find_energy` there."""
    n = len(q)
    out, one, two = work.hessian, work.before, work.after
    for a in range(n):
        for b in range(n):
            out[a, b] = layout.stiffness[a, b] + rate * layout.damping[a, b]
    curvature_of_points(layout, two, work.force, work.left, work.right, work.total, out)
    if len(work.taut) > 0:
        add_tendon_stiffness(layout, q, work.taut, 1.0, work.paths_after, out)
    for i in range(len(work.taut)):
        if loads.driven[i] and work.taut[i] > 0.0:
            for a in range(n):
                left = layout.tendon_stiffness[i] * work.paths_after.gradient[i, a]
                for b in range(n):
                    out[a, b] += left * work.paths_after.gradient[i, b]
    if rate == 0.0:
        return
    for j in range(len(layout.mass)):
        k, factor = layout.place[j], layout.mass[j] * rate * rate
        last = layout.last[k - 1]
        for a in range(last):
            x, y, z = factor * two.jacobian[j, 0, a], factor * two.jacobian[j, 1, a], factor * two.jacobian[j, 2, a]
            for b in range(last):
                out[a, b] += x * two.jacobian[j, 0, b] + y * two.jacobian[j, 1, b] + z * two.jacobian[j, 2, b]
        for c in range(3):
            if layout.drag[j, c] != 0.0:
                rx, ry, rz = one.rotation[k, c], one.rotation[k, 3 + c], one.rotation[k, 6 + c]
                along = rx * (two.point[j, 0] - one.point[j, 0]) + ry * (two.point[j, 1] - one.point[j, 1])
                along += rz * (two.point[j, 2] - one.point[j, 2])
                slope = 2.0 * layout.drag[j, c] * abs(along) * rate * rate
                for a in range(last):
                    left = rx * two.jacobian[j, 0, a] + ry * two.jacobian[j, 1, a] + rz * two.jacobian[j, 2, a]
                    for b in range(last):
                        out[a, b] += (
                            slope
                            * left
                            * (rx * two.jacobian[j, 0, b] + ry * two.jacobian[j, 1, b] + rz * two.jacobian[j, 2, b])
                        )
    for k in range(1, len(layout.polar)):
        last, factor = layout.last[k - 1], layout.polar[k] * rate * rate
        if factor != 0.0:
            for a in range(last):
                for b in range(last):
                    out[a, b] += factor * one.spin[k, a] * one.spin[k, b]


@lean
def minimise(layout: Layout, loads: Loads, q: Array, rate: float, tolerance: float, work: Scratch) -> int:
    """Move q to a minimum of the energy, in place.

    Args:
        layout: of the robot.
        loads: on it.
        q: strains, shape (n,).
        rate: 1 / h of an implicit Euler step [1/s], after `begin_step`; 0: statics.
        tolerance: of q [rad], in the measure of energy.
        work: scratch arrays.

    Returns:
        Newton's iterations; -1 where they came to no end, and q has the least energy found.
    """
    n = len(q)
    damping = 0.0
    moments = False
    if rate == 0.0:
        for k in range(1, len(layout.polar)):
            for c in range(3):
                moments |= loads.moment[k, c] != 0.0
    target = tolerance * tolerance * work.unit[0]
    step, trial, residual, last = work.correction, work.trial, work.pull, work.row
    energy, size = find_energy(layout, loads, q, rate, work)
    fresh, decrement, last_decrement = False, np.inf, np.inf
    for a in range(n):
        residual[a] = work.residual[a]
    for count in range(1, ITERATIONS + 1):
        last_decrement = np.inf  # of an undamped step from here
        if not fresh:
            find_hessian(layout, loads, q, rate, work)
        while True:
            if not fresh:
                for a in range(n):
                    for b in range(n):
                        work.matrix[a, b] = work.hessian[a, b]
                    work.matrix[a, a] += damping * layout.stiffness[a, a]
                    step[a] = residual[a]
                positive = factor_symmetric(work.matrix, n)
                if positive:
                    solve_symmetric(work.matrix, step, n)
            else:
                positive = True
            if positive:
                decrement = 0.0
                for a in range(n):
                    decrement += step[a] * residual[a]
                    trial[a] = q[a] - step[a]
                if damping == 0.0:
                    last_decrement = decrement
                found, other = find_energy(layout, loads, trial, rate, work)
                if moments:
                    for a in range(n):
                        last[a] = work.residual[a]
                    solve_symmetric(work.matrix, last, n)
                    before = after = 0.0
                    for a in range(n):
                        before += layout.stiffness[a, a] * step[a] * step[a]
                        after += layout.stiffness[a, a] * last[a] * last[a]
                    if after < before or after < target:
                        break
                elif found <= energy - 1e-4 * decrement + ROUNDING * size:
                    break
            if fresh:
                fresh = False
                find_energy(layout, loads, q, rate, work)
                find_hessian(layout, loads, q, rate, work)
                continue
            damping = max(4.0 * damping, 1e-3)
            if damping > 1e15:  # no way down: this is the place, if rounding is what hides it
                return count if last_decrement <= ATTAINED * size else -1
        undamped = damping == 0.0
        damping = 0.25 * damping if damping > 1e-3 else 0.0
        energy, size = found, other
        for a in range(n):
            q[a] = trial[a]
            residual[a] = work.residual[a]
            step[a] = residual[a]
        fresh = False
        if undamped:
            solve_symmetric(work.matrix, step, n)
            left = 0.0
            for a in range(n):
                left += layout.stiffness[a, a] * step[a] * step[a] if moments else step[a] * residual[a]
            left = abs(left)
            if left <= target or (decrement <= ROUNDING * size and left > 0.25 * decrement):
                return count
            fresh = left <= CONTRACTION * decrement and not moments
    return -1


def stiffness_of(layout: Layout, loads: Loads, q: Array, work: Scratch) -> Array:
    """Return the second derivative of the energy at an equilibrium, shape (n, n); its eigenvalues tell stability."""
    find_energy(layout, loads, q, 0.0, work)
    find_hessian(layout, loads, q, 0.0, work)
    return work.hessian.copy()
