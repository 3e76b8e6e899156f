"""How the tip answers to the tendons and to a force on it: from the solver's own Jacobian, not from more solves."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, kernel
from tendond.model.numerics.linear import solve_in_place
from tendond.model.solver.march import STATE, march
from tendond.model.solver.shooting import RodData, differentiate, evaluate, newton_matrix, perturbation, pull
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
def velocity_jacobian(
    rod: RodData, memory: Any, c0: float, tendon: int, unknown: Any, loads: Any, history: Any, levels: Any,
    geometry: Any, response: Any,
) -> bool:  # fmt: skip
    """Of a tension-driven rod: how the tip's velocity after the last step answers to one tendon's tension.

    One march of eight lanes says it all: six with a base load changed, one with the tension, one as the rod is.
    `response`, shape (3,), is filled [m/s/N]; `levels` and `geometry` are scratch. False where it is singular.
    """
    n, still, pulled = len(rod.x), LANES - 1, LANES - 2
    work = open_work(memory, n)
    for lane in range(LANES):
        for j in range(6):
            work.base[j * LANES + lane] = unknown[j]
        for i in range(n):
            work.tension[i * LANES + lane] = unknown[6 + i]
    for j in range(6):
        work.base[j * LANES + j] += perturbation(work, unknown, j)
    work.tension[tendon * LANES + pulled] += perturbation(work, unknown, 6 + tendon)
    march(
        rod.many, rod.x, rod.y, rod.constants, rod.tableau, rod.weights, rod.flags, rod.steps, rod.ds, c0, work.base,
        work.tension, loads[n:], rod.push, history, levels, geometry, work.march, work.node, work.length, work.residual,
    )  # fmt: skip
    whole = 1.0 / perturbation(work, unknown, 6 + tendon)
    for j in range(6):
        missing = work.residual[j * LANES + still]
        for k in range(6):
            work.matrix[j, k] = (work.residual[j * LANES + k] - missing) / perturbation(work, unknown, k)
        work.step[j] = (missing - work.residual[j * LANES + pulled]) * whole
    if not solve_in_place(work.matrix, work.step, 6):
        return False
    for j in range(STATE):
        rest = work.node[j * LANES + still]
        work.tip[j, 0] = (work.node[j * LANES + pulled] - rest) * whole
        for k in range(6):
            work.tip[j, 0] += (work.node[j * LANES + k] - rest) / perturbation(work, unknown, k) * work.step[k]
    for j in range(3):  # of R q
        response[j] = 0.0
        for k in range(3):
            R, q = work.node[(3 + 3 * j + k) * LANES + still], work.node[(18 + k) * LANES + still]
            response[j] += work.tip[3 + 3 * j + k, 0] * q + R * work.tip[18 + k, 0]
    return True


@kernel
def tip_sensitivity(
    rod: RodData,
    memory: Any,
    c0: float,
    displacement_driven: bool,
    unknown: Any,
    loads: Any,
    history: Any,
    levels: Any,
    geometry: Any,
    jacobian: Any,
    actuation: Any,
    force: Any,
) -> bool:
    """Fill `actuation`, shape (6, n), and `force`, shape (6, 3): position then velocity against each.

    `levels` and `geometry` are scratch; `jacobian`, shape (6 + n, 6 + n), is overwritten. False where the equations are
    singular.
    """
    n = len(rod.x)
    work = open_work(memory, n)
    evaluate(rod, work, c0, unknown, loads, history, levels, geometry, work.raw)
    differentiate(rod, work, c0, unknown, work.raw, 6 + n, loads, history, levels, geometry, jacobian)
    last, strain = geometry[geometry.shape[0] - 1], levels[levels.shape[0] - 1]
    solvable = True
    for column in range(n + 3):
        m = newton_matrix(rod, work, displacement_driven, work.raw, loads, jacobian)
        direct = -1
        for j in range(m):
            work.step[j] = 0.0
        if column >= n:  # a force of 1 N on the tip along a world axis: R' of it is missing there
            for j in range(3):
                work.step[j] = last[3 + 3 * (column - n) + j]
        elif displacement_driven:
            work.step[6 + column] = rod.stiffness if pull(rod, work.raw, loads, column) > 0.0 else 0.0
        else:
            direct = 6 + column
            for j in range(6):
                work.step[j] = -jacobian[j, direct]
        solvable = solve_in_place(work.matrix, work.step, m) and solvable
        target, at = (actuation, column) if column < n else (force, column - n)
        follow(work, last, strain, m, direct, target, at)
    return solvable


@inlined
def follow(work: Work, last: Any, strain: Any, m: int, direct: int, target: Any, at: int) -> None:
    """Column `at` of `target`: how the tip's position and velocity change with the unknowns; `work.node` its state.

    The m unknowns change by `work.step`, and the unknown `direct` by one beside them; -1: none.
    """
    for j in range(STATE):
        work.node[j] = work.tip[j, direct] if direct >= 0 else 0.0
        for k in range(m):
            work.node[j] += work.tip[j, k] * work.step[k]
    for j in range(3):
        target[j, at] = work.node[j]
        velocity = 0.0
        for k in range(3):
            velocity += work.node[3 + 3 * j + k] * strain[6 + k] + last[3 + 3 * j + k] * work.node[18 + k]
        target[3 + j, at] = velocity
