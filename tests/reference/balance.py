"""Balance of momentum of the whole rod, with its tendons: a check of the dynamics that needs none of the 6x6 system.

Rod and tendons as one body, world frame, moments about the origin; N, M as in converged.py:

    integral of rhoA a - f = F_tip - N(0)
    integral of p x (rhoA a - f) + R (w x rhoJ w + rhoJ w_t) - l = p(L) x F_tip + M_tip - M(0)

with a = R (w x q + q_t) and f = rhoA g - R C q |q| + f_ext.
"""

from __future__ import annotations

import numpy as np

from tests.reference.equations import STRAIN, Q, U, W
from tests.reference.rod import Array
from tests.reference.solution import Solution


def base_reaction(solution: Solution) -> tuple[Array, Array]:
    """N(0) [N] and M(0) [N m]: what backbone and tendons together carry at s = 0, where R = I, shape (3,) each."""
    rod, y = solution.rod, solution.sweep.y[0]
    N, M = solution.base_load[:3].copy(), solution.base_load[3:].copy()
    for T, r in zip(solution.tensions, rod.tendon_positions, strict=True):
        slope = rod.v_star + y[STRAIN] + np.cross(y[U], r)
        N += T * slope / np.linalg.norm(slope)
        M += T * np.cross(r, slope) / np.linalg.norm(slope)
    return N, M


def imbalance(solution: Solution) -> tuple[float, float]:
    """Remainder of the two balances [-], as parts of |N(0)| and |M(0)|: the space scheme's error."""
    rod, loads, swept = solution.rod, solution.loads, solution.sweep
    quadrature = np.tile(solution.scheme.tableau.b, solution.scheme.steps) * rod.length / solution.scheme.steps
    force, moment = np.zeros(3), np.zeros(3)
    for weight, p, R, y, y_t in zip(quadrature, swept.p, swept.R, swept.y, swept.y_t, strict=False):
        q, w = y[Q], y[W]
        f = rod.rhoA * loads.gravity - R @ rod.C @ (q * np.abs(q)) + loads.distributed_force_world
        inertia = rod.rhoA * R @ (np.cross(w, q) + y_t[Q]) - f
        spin = R @ (np.cross(w, rod.rhoJ @ w) + rod.rhoJ @ y_t[W])
        force += weight * inertia
        moment += weight * (np.cross(p, inertia) + spin - loads.distributed_moment_world)
    N, M = base_reaction(solution)
    force -= loads.tip_force_world - N
    moment -= np.cross(swept.p[-1], loads.tip_force_world) + loads.tip_moment_world - M
    return float(np.linalg.norm(force) / np.linalg.norm(N)), float(np.linalg.norm(moment) / np.linalg.norm(M))
