"""Jacobians of the tip by the tendons and by a force on it: from the solver's own Jacobian, not from more solves."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import borrowed, inlined, kernel
from tendond.model.numerics.linear import solve_in_place
from tendond.model.solver.lanes import STATE
from tendond.model.solver.march import march
from tendond.model.solver.predictor import RING
from tendond.model.solver.problem import Bdf, Problem, Profile, RodData, StateData, borrowed_rod, borrowed_state
from tendond.model.solver.shooting import (
    change,
    differentiate,
    evaluate,
    newton_matrix,
    perturb,
    perturbation,
    spread,
    string_tension,
)
from tendond.model.solver.work import LANES, Work, open_work

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives of the tip, after the last step (in statics: of the equilibrium), world frame.

    The actuation is the tendons' tension [N], or, in a displacement-driven rod, their commanded displacement [m].

    Attributes:
        position_actuation: d(position)/d(actuation) [m/N or -], shape (3, n).
        velocity_actuation: d(velocity)/d(actuation) [m/s/N or 1/s], shape (3, n).
        position_force: d(position)/d(tip force) [m/N], shape (3, 3).
        velocity_force: d(velocity)/d(tip force) [m/s/N], shape (3, 3).
    """

    position_actuation: Array
    velocity_actuation: Array
    position_force: Array
    velocity_force: Array


@kernel
def velocity_jacobian(rod: RodData, memory: Any, bdf: Bdf, state: StateData, tendon: int, out: Any) -> bool:
    """Derivative of the tip's velocity after the last step of a tension-driven rod by one tendon's tension.

    One march of eight lanes suffices: six with a base load changed, one with the tension, one as the rod is. `out`,
    shape (3,), is filled [m/s/N]. False where the equations are singular.
    """
    rest, pulled, now, free = LANES - 1, LANES - 2, state.step, state.step + 1
    rod, state, work = borrowed_rod(rod), borrowed_state(state), open_work(borrowed(memory), rod)
    unknown = state.unknowns[now % RING]
    problem = Problem(bdf[0], False, state.loads, state.histories[now % 2])
    profile = Profile(state.levels[free % 3], state.geometries[free % 2])  # of the next step: not in use
    shots = work.shots
    spread(rod, work, unknown)
    for j in range(6):
        perturb(work, j, j, perturbation(work, unknown, j))
    step = perturbation(work, unknown, 6 + tendon)
    perturb(work, 6 + tendon, pulled, step)
    march(rod.many, rod, problem, shots, profile)
    inverse = 1.0 / step
    for j in range(6):
        missing = shots.residual[j * LANES + rest]
        for k in range(6):
            work.matrix[j, k] = change(shots.residual, j, k, missing) / perturbation(work, unknown, k)
        work.step[j] = -change(shots.residual, j, pulled, missing) * inverse
    if not solve_in_place(work.matrix, work.step, 6):
        return False
    for j in range(STATE):
        at_rest = shots.node[j * LANES + rest]
        work.tip[j, 0] = change(shots.node, j, pulled, at_rest) * inverse
        for k in range(6):
            work.tip[j, 0] += change(shots.node, j, k, at_rest) / perturbation(work, unknown, k) * work.step[k]
    for j in range(3):  # of R q
        out[j] = 0.0
        for k in range(3):
            R, q = shots.node[(3 + 3 * j + k) * LANES + rest], shots.node[(18 + k) * LANES + rest]
            out[j] += work.tip[3 + 3 * j + k, 0] * q + R * work.tip[18 + k, 0]
    return True


@kernel
def tip_sensitivity(
    rod: RodData, memory: Any, problem: Problem, unknown: Any, profile: Profile, jacobian: Any, actuation: Any,
    force: Any,
) -> bool:  # fmt: skip
    """Fill `actuation`, shape (6, n), and `force`, shape (6, 3): derivatives of position, then velocity, by each.

    The profile is scratch; `jacobian`, shape (6 + n, 6 + n), is overwritten. False where the equations are singular.
    """
    n = rod.tendons
    rod, work = borrowed_rod(rod), open_work(borrowed(memory), rod)
    evaluate(rod, work, problem, unknown, profile, work.raw)
    differentiate(rod, work, problem, unknown, 6 + n, profile, jacobian)
    last, strain = profile.geometry[profile.geometry.shape[0] - 1], profile.levels[profile.levels.shape[0] - 1]
    solvable = True
    for column in range(n + 3):
        m = newton_matrix(rod, work, problem, jacobian)
        direct = -1
        for j in range(m):
            work.step[j] = 0.0
        if column >= n:  # a force of 1 N on the tip along a world axis: R' of it is missing there
            for j in range(3):
                work.step[j] = last[3 + 3 * (column - n) + j]
        elif problem.displacement_driven:
            taut = string_tension(rod, problem, work.raw, column) > 0.0
            work.step[6 + column] = rod.stiffness if taut else 0.0
        else:
            direct = 6 + column
            for j in range(6):
                work.step[j] = -jacobian[j, direct]
        solvable = solve_in_place(work.matrix, work.step, m) and solvable
        target, at = (actuation, column) if column < n else (force, column - n)
        tip_derivative(work, last, strain, m, direct, target, at)
    return solvable


@inlined
def tip_derivative(work: Work, last: Any, strain: Any, m: int, direct: int, target: Any, at: int) -> None:
    """Fill column `at` of `target` with the change of the tip's position and velocity; the node of `work` with R's.

    The m unknowns change by `work.step`, and the unknown `direct` by one beside them; -1: none. `last` and `strain` are
    the tip's rows of the profile.
    """
    node = work.shots.node
    for j in range(STATE):
        node[j] = work.tip[j, direct] if direct >= 0 else 0.0
        for k in range(m):
            node[j] += work.tip[j, k] * work.step[k]
    for j in range(3):
        target[j, at] = node[j]
        velocity = 0.0
        for k in range(3):
            velocity += node[3 + 3 * j + k] * strain[6 + k] + last[3 + 3 * j + k] * node[18 + k]
        target[3 + j, at] = velocity
