"""Equilibria of the strain rod as minima of its potential energy: what is found is stable, and says so.

V(q) = q' K q / 2 - sum f . x(q) - sum of the tendons' work, for dead forces. A damped Newton method (Levenberg and
Marquardt) on V goes downhill from where it starts: a rod that is loaded slowly gets to the same place. Dead moments are
no gradient of any energy: with them, the residual decides instead.
"""

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import kernel
from tendond.model.strain.dynamics import Loads, Scratch
from tendond.model.strain.kinematics import curvature_of_points, find_shape
from tendond.model.strain.layout import Layout
from tendond.model.strain.linear import cholesky, cholesky_solve
from tendond.model.strain.tendons import add_tendon_stiffness, find_paths

Array = NDArray[np.float64]

ITERATIONS = 200


@kernel
def energy_and_residual(layout, loads, q, work):  # type: ignore[no-untyped-def]
    """Write the residual of statics at q; return the energy [J], the residual's size, and that of its largest part."""
    n = len(q)
    find_shape(layout, q, work.after)
    find_paths(layout, q, work.paths_after)
    energy = size = 0.0
    for a in range(n):
        value = 0.0
        for b in range(n):
            value += layout.stiffness[a, b] * q[b]
        energy += 0.5 * value * q[a]
        work.residual[a] = value
        size = max(size, abs(value))
    for i in range(len(work.taut)):
        if loads.driven[i]:
            stretch = max(0.0, loads.tension[i] - work.paths_after.displacement[i])
            work.taut[i] = layout.tendon_stiffness[i] * stretch
            energy += 0.5 * layout.tendon_stiffness[i] * stretch * stretch
        else:
            work.taut[i] = loads.tension[i]
            energy -= loads.tension[i] * work.paths_after.displacement[i]
        if work.taut[i] != 0.0:
            for a in range(n):
                pull = work.taut[i] * work.paths_after.gradient[i, a]
                work.residual[a] -= pull
                size = max(size, abs(pull))
    for j in range(len(layout.mass)):
        for i in range(3):
            work.force[j, i] = -layout.mass[j] * layout.gravity[i] - loads.force[j, i]
            energy += work.force[j, i] * work.after.point[j, i]
        for a in range(n):
            part = 0.0
            for i in range(3):
                part += work.after.jacobian[j, a, i] * work.force[j, i]
            work.residual[a] += part
            size = max(size, abs(part))
    for k in range(1, len(layout.polar)):
        x, y, z = loads.moment[k, 0], loads.moment[k, 1], loads.moment[k, 2]
        if x != 0.0 or y != 0.0 or z != 0.0:
            for a in range(n):
                t = work.after.twist[k, a]
                part = x * t[0] + y * t[1] + z * t[2]
                work.residual[a] -= part
                size = max(size, abs(part))
    left = 0.0
    for a in range(n):
        left = max(left, abs(work.residual[a]))
    return energy, left, size


@kernel
def energy_hessian(layout, loads, q, work, out):  # type: ignore[no-untyped-def]
    """Write the second derivative of the energy at q, shape (n, n), after `energy_and_residual` there."""
    n = len(q)
    out[:, :] = 0.0
    curvature_of_points(layout, work.after, work.force, out)
    add_tendon_stiffness(layout, q, work.taut, 1.0, out)
    for a in range(n):
        for b in range(n):
            out[a, b] += layout.stiffness[a, b]
    for i in range(len(work.taut)):
        if loads.driven[i] and work.taut[i] > 0.0:
            for a in range(n):
                for b in range(n):
                    out[a, b] += (
                        layout.tendon_stiffness[i] * work.paths_after.gradient[i, a] * work.paths_after.gradient[i, b]
                    )


@kernel
def minimise(layout, loads, q, tolerance, work):  # type: ignore[no-untyped-def]
    """Move q to a minimum of the energy, in place; return the iterations, or -1 where none was found."""
    n = len(q)
    damping = 0.0
    moments = np.any(loads.moment != 0.0)
    energy, left, size = energy_and_residual(layout, loads, q, work)
    trial, change = np.empty(n), np.empty(n)
    hessian = np.empty((n, n))
    for count in range(ITERATIONS):
        if left <= tolerance * size:
            return count
        energy_hessian(layout, loads, q, work, hessian)
        residual = work.residual.copy()
        while True:
            for a in range(n):
                change[a] = residual[a]
                for b in range(n):
                    work.matrix[a, b] = hessian[a, b]
                work.matrix[a, a] += damping * layout.stiffness[a, a]
            lower = cholesky(work.matrix)
            if lower:
                cholesky_solve(work.matrix, change)
                for a in range(n):
                    trial[a] = q[a] - change[a]
                found, new_left, new_size = energy_and_residual(layout, loads, trial, work)
                if moments:
                    if new_left < left:
                        break
                elif found < energy or (new_left < left and found <= energy + 1e-10 * abs(energy)):
                    break
            damping = max(4.0 * damping, 1e-3)
            if damping > 1e12:
                return -1
        damping = 0.25 * damping if damping > 1e-3 else 0.0
        for a in range(n):
            q[a] = trial[a]
        energy, left, size = found, new_left, new_size
    return -1


def stiffness_of(layout: Layout, loads: Loads, q: Array, work: Scratch) -> Array:
    """Return the second derivative of the energy at an equilibrium, shape (n, n); its eigenvalues tell stability."""
    out = np.zeros((len(q), len(q)))
    energy_and_residual(layout, loads, q, work)
    energy_hessian(layout, loads, q, work, out)
    return out
