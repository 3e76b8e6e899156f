"""One sweep along the rod: from a guess of n(0), m(0) to the residual at the tip, with every point kept."""

from __future__ import annotations

from dataclasses import dataclass
from math import fsum

import numpy as np

from tests.reference.equations import STRAIN, Loads, Point, U, evaluate, tendon_slopes, tip_residual
from tests.reference.rod import Array, ReferenceRod
from tests.reference.schemes import Scheme


@dataclass(frozen=True, eq=False)
class Sweep:
    """The rod at all P points of a scheme, n tendons."""

    p: Array
    """Position [m], world frame, shape (P, 3)."""
    R: Array
    """Body to world, shape (P, 3, 3)."""
    y: Array
    """v - v*, u, q, w, v_s, u_s, shape (P, 6, 3)."""
    y_t: Array
    """Their derivatives by time, shape (P, 6, 3)."""
    path_lengths: Array
    """Length of each tendon along the rod [m], shape (n,)."""
    residual: Array
    """Force [N] and moment [N m] left over at the tip, body frame, shape (6,)."""


def newton_schulz(R: Array) -> Array:
    """One iteration towards the nearest rotation, shape (3, 3)."""
    return R @ (3.0 * np.eye(3) - R.T @ R) / 2.0


def base_state(rod: ReferenceRod, c0: float, y_h: Array, base_load: Array) -> Array:
    """v - v*, u, q, w at s = 0, shape (4, 3), that carry the base load n(0), m(0), shape (6,)."""
    strain = np.linalg.solve(rod.Kse + c0 * rod.Bse, base_load[:3] - rod.Bse @ y_h[STRAIN])
    u = np.linalg.solve(rod.Kbt + c0 * rod.Bbt, base_load[3:] + rod.Kbt @ rod.u_star - rod.Bbt @ y_h[U])
    return np.array([strain, u, np.zeros(3), np.zeros(3)])


def path_lengths(rod: ReferenceRod, scheme: Scheme, y: Array) -> Array:
    """Length of each tendon along the rod [m], shape (n,): the integral of |p_i'|, summed without rounding errors."""
    slopes = np.array([np.linalg.norm(tendon_slopes(rod, rod.v_star + at[STRAIN], at[U]), axis=1) for at in y])
    h = rod.length / scheme.steps
    if scheme.trapezoidal_path:
        terms = (slopes[:-1] + slopes[1:]) / 2.0
    else:
        terms = np.tile(scheme.tableau.b, scheme.steps)[:, None] * slopes[:-1]
    return h * np.array([fsum(column) for column in terms.T])


def sweep(rod: ReferenceRod, scheme: Scheme, loads: Loads, c0: float, y_h: Array, base_load: Array) -> Sweep:
    """Integrate from s = 0 to L with the history y_h, shape (P, 6, 3), and evaluate s = L too."""
    tableau, h = scheme.tableau, rod.length / scheme.steps
    position, rotation = np.zeros(3), np.eye(3)
    state = base_state(rod, c0, y_h[0], base_load)
    p, R = np.empty((scheme.points, 3)), np.empty((scheme.points, 3, 3))
    y, y_t = np.empty((scheme.points, 6, 3)), np.empty((scheme.points, 6, 3))
    for step in range(scheme.steps):
        stages: list[Point] = []
        for stage in range(tableau.stages):
            stage_p, stage_R, stage_state = position, rotation, state
            for weight, earlier in zip(tableau.A[stage], stages, strict=False):
                stage_p = stage_p + h * weight * earlier.p_s
                stage_R = stage_R + h * weight * earlier.R_s
                stage_state = stage_state + h * weight * earlier.y_s
            at = step * tableau.stages + stage
            point = evaluate(rod, loads, c0, y_h[at], stage_R, stage_state)
            p[at], R[at], y[at], y_t[at] = stage_p, stage_R, point.y, point.y_t
            stages.append(point)
        for weight, point in zip(tableau.b, stages, strict=True):
            position = position + h * weight * point.p_s
            rotation = rotation + h * weight * point.R_s
            state = state + h * weight * point.y_s
        if scheme.orthonormalise:
            rotation = newton_schulz(newton_schulz(rotation))
    point = evaluate(rod, loads, c0, y_h[-1], rotation, state)
    p[-1], R[-1], y[-1], y_t[-1] = position, rotation, point.y, point.y_t
    return Sweep(p, R, y, y_t, path_lengths(rod, scheme, y), tip_residual(rod, loads, rotation, point))
