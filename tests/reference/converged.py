"""Statics by another route: the rod and its tendons as one body, to the accuracy of DOP853 at 1e-12.

Across a section the backbone carries n, m and each tendon T_i t_i, t_i = p_i' / |p_i'|. Together, in the world frame,

    N = R (n + sum T_i t_i)             N_s = -rhoA g - f_ext             N(L) = F_tip
    M = R (m + sum r_i x T_i t_i)       M_s = -p_s x N - l_ext            M(L) = M_tip

so that N is known beforehand, the tendons' distributed loads never appear, and only M(0) has to be found. The strains
v, u at a point are the root of n(v) + sum T_i t_i = R'N, m(u) + sum r_i x T_i t_i = R'M. None of the 6x6 system of the
other modules is used; R is a quaternion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from tests.reference.equations import Loads
from tests.reference.rod import Array, ReferenceRod, hat
from tests.reference.roots import find_root
from tests.reference.solver import ZERO, continued


@dataclass(frozen=True, eq=False)
class ConvergedShape:
    """A static shape with no discretisation error to speak of; n tendons."""

    tip_position: Array
    """Position [m], world frame, shape (3,)."""
    tip_rotation: Array
    """Body to world, shape (3, 3)."""
    tendon_displacements: Array
    """L less the path length [m], shape (n,)."""
    base_load: Array
    """n(0) [N] and m(0) [N m] of the backbone, shape (6,)."""


def rotation(quaternion: Array) -> Array:
    """R of a quaternion (w, x, y, z) of any length, shape (3, 3)."""
    w, axis = quaternion[0], quaternion[1:]
    return np.asarray(np.eye(3) + 2.0 * (w * hat(axis) + hat(axis) @ hat(axis)) / (quaternion @ quaternion))


def strains(rod: ReferenceRod, tensions: Array, force: Array, moment: Array, near: Array) -> Array:
    """v - v* and u - u*, shape (6,), at which backbone and tendons carry this force [N] and moment [N m], body frame.

    Newton from `near`; its Jacobian is exact: T (I - t t') / |p'| is the derivative of T t by p'.
    """
    x = near
    stiffness = np.block([[rod.Kse, np.zeros((3, 3))], [np.zeros((3, 3)), rod.Kbt]])
    for _ in range(30):
        v, u = rod.v_star + x[:3], rod.u_star + x[3:]
        residual, jacobian = stiffness @ x - np.concatenate([force, moment]), stiffness.copy()
        for T, r in zip(tensions, rod.tendon_positions, strict=True):
            slope = v + np.cross(u, r)
            length = np.linalg.norm(slope)
            direction = slope / length
            by_slope = T * (np.eye(3) - np.outer(direction, direction)) / length
            lever = np.vstack([np.eye(3), hat(r)])
            residual += lever @ (T * direction)
            jacobian += lever @ by_slope @ lever.T
        change = np.linalg.solve(jacobian, residual)
        x = x - change
        if np.max(np.abs(change[:3])) < 1e-15 and np.max(np.abs(change[3:])) < 1e-12:
            break
    return x


def integrate(rod: ReferenceRod, loads: Loads, base_moment: Array) -> tuple[Array, ConvergedShape]:
    """M(L) - M_tip [N m], shape (3,), and the shape for a guess of M(0), world frame, shape (3,)."""
    per_length = rod.rhoA * loads.gravity + loads.distributed_force_world
    near = np.zeros(6)

    def section(s: float, y: Array) -> tuple[Array, Array, Array]:
        nonlocal near
        R, force = rotation(y[3:7]), loads.tip_force_world + (rod.length - s) * per_length
        near = strains(rod, loads.tensions, R.T @ force, R.T @ y[7:10], near)
        return R, force, near

    def slope(s: float, y: Array) -> Array:
        R, force, strain = section(s, y)
        v, u = rod.v_star + strain[:3], rod.u_star + strain[3:]
        p_s = R @ v
        w, axis = y[3], y[4:7]
        quaternion_s = 0.5 * np.concatenate([[-axis @ u], w * u + np.cross(axis, u)])
        M_s = -np.cross(p_s, force) - loads.distributed_moment_world
        paths_s = [np.linalg.norm(v + np.cross(u, r)) for r in rod.tendon_positions]
        return np.concatenate([p_s, quaternion_s, M_s, paths_s])

    start = np.concatenate([np.zeros(3), [1.0], np.zeros(3), base_moment, np.zeros(len(loads.tensions))])
    strain = section(0.0, start)[2]
    path = solve_ivp(slope, (0.0, rod.length), start, method="DOP853", rtol=1e-12, atol=1e-14)
    end = np.asarray(path.y[:, -1], dtype=np.float64)
    shape = ConvergedShape(
        tip_position=end[:3],
        tip_rotation=rotation(end[3:7]),
        tendon_displacements=rod.length - end[10:],
        base_load=np.concatenate([rod.Kse @ strain[:3], rod.Kbt @ strain[3:]]),
    )
    return end[7:10] - loads.tip_moment_world, shape


def converged_static(
    rod: ReferenceRod,
    tensions: Array,
    tip_force_world: Array = ZERO,
    tip_moment_world: Array = ZERO,
    distributed_force_world: Array = ZERO,
    distributed_moment_world: Array = ZERO,
) -> ConvergedShape:
    """The static shape that the rod is led to when these loads (as in Loads) grow together from none."""
    none = Loads(np.zeros(len(rod.tendon_positions)), ZERO)
    loads = Loads(
        np.asarray(tensions, dtype=np.float64),
        rod.gravity,
        np.asarray(tip_force_world, dtype=np.float64),
        np.asarray(tip_moment_world, dtype=np.float64),
        np.asarray(distributed_force_world, dtype=np.float64),
        np.asarray(distributed_moment_world, dtype=np.float64),
    )
    scale = np.full(3, rod.Kbt[0, 0] / rod.length)

    def solve(fraction: float, near: Array) -> Array:
        part = none.blend(loads, fraction)
        return find_root(lambda moment: integrate(rod, part, moment)[0], near, scale, tolerance=1e-13, accept=1e-11)

    return integrate(rod, loads, continued(solve, np.zeros(3), first=0.25))[1]
