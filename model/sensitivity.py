"""How the tip answers to the tendons and to a force on it: from the solver's own Jacobian, not from more solves."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model.compile import inlined, kernel
from tendond.model.linear import solve_in_place
from tendond.model.march import STATE
from tendond.model.predictor import predict
from tendond.model.shooting import RodData, differentiate, evaluate, newton_matrix, newton_step, pull
from tendond.model.timestep import step_history
from tendond.model.work import Work, open_work

Array = NDArray[np.float64]

CORRECTIONS = 2
"""Marches of a forecast beside the one at the first guess."""


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives of the tip, after the last step (in statics: of the equilibrium), world frame.

    The actuation is the tendons' tension [N], or, in a displacement-driven rod, their commanded displacement [m].

    Attributes:
        position_actuation: d(position)/d(actuation) [m/N or -], shape (3, n).
        velocity_actuation: d(velocity)/d(actuation) [m/s/N or 1/s], shape (3, n).
        position_force: d(position)/d(tip force) [m/N], shape (3, 3).
        velocity_force: d(velocity)/d(tip force) [m/s/N], shape (3, 3).
        direction_actuation: d(R e_z)/d(actuation) [1/N or 1/m], shape (3, n). direction_force: d/d(tip force) [1/N].
    """

    position_actuation: Array
    velocity_actuation: Array
    position_force: Array
    velocity_force: Array
    direction_actuation: Array
    direction_force: Array

    @staticmethod
    def from_rows(actuation: Array, force: Array) -> "Sensitivity":
        """From the kernels' rows: position, velocity, direction."""
        return Sensitivity(actuation[:3], actuation[3:6], force[:3], force[3:6], actuation[6:], force[6:])


@dataclass(frozen=True)
class Forecast:
    """The tip after the coming step, world frame, and how it answers to the tendons.

    Attributes:
        position: [m], shape (3,), if the loads are as they were given. velocity, direction: likewise [m/s], [-].
        sensitivity: of that step.
    """

    position: Array
    velocity: Array
    direction: Array
    sensitivity: Sensitivity


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
    """Fill `actuation`, shape (9, n), and `force`, shape (9, 3): position, velocity, direction against each.

    `levels` and `geometry` are scratch; `jacobian`, shape (6 + n, 6 + n), is overwritten. False where the equations are
    singular.
    """
    n = len(rod.x)
    work = open_work(memory, n)
    evaluate(rod, work, c0, unknown, loads, history, levels, geometry, work.raw)
    differentiate(rod, work, c0, unknown, work.raw, 6 + n, loads, history, levels, geometry, jacobian)
    return bool(_respond(rod, work, displacement_driven, loads, jacobian, levels, geometry, actuation, force))


@kernel
def tip_forecast(
    rod: RodData,
    memory: Any,
    bdf: tuple[float, float, float, float],
    displacement_driven: bool,
    count: int,
    levels: Any,
    histories: Any,
    unknowns: Any,
    loads: Any,
    history: Any,
    level: Any,
    geometry: Any,
    jacobian: Any,
    tip: Any,
    actuation: Any,
    force: Any,
) -> bool:
    """Fill `tip`, shape (9,), with position, velocity, direction after the next step; `actuation`, `force` as above.

    The step's equations are linearised at its first guess; what that misses when the motion changes fast, a march or
    two with the same Jacobian put right. The rings are those of `timestep.advance`, `history` to `jacobian` scratch.
    """
    n = len(rod.x)
    work = open_work(memory, n)
    step_history(bdf, count, levels, histories, history)
    unknown = work.last
    predict(unknowns, count, work.scale, work.differences, 6 + n if displacement_driven else 6, unknown)
    if not displacement_driven:
        for i in range(n):
            unknown[6 + i] = loads[i]
    evaluate(rod, work, bdf[0], unknown, loads, history, level, geometry, work.raw)
    differentiate(rod, work, bdf[0], unknown, work.raw, 6 + n, loads, history, level, geometry, jacobian)
    last, strain = geometry[geometry.shape[0] - 1], level[level.shape[0] - 1]
    m = 6 + n if displacement_driven else 6
    solvable = True
    for more in range(CORRECTIONS, -1, -1):
        solvable = newton_step(rod, work, displacement_driven, unknown, work.raw, loads, jacobian) and solvable
        if more > 0:
            for j in range(m):
                unknown[j] += work.step[j]
            evaluate(rod, work, bdf[0], unknown, loads, history, level, geometry, work.raw)
    _follow(work, last, strain, m, -1, actuation, 0)
    for j in range(3):
        velocity = 0.0
        for k in range(3):
            velocity += last[3 + 3 * j + k] * strain[6 + k]
        tip[j] = last[j] + actuation[j, 0]
        tip[3 + j] = velocity + actuation[3 + j, 0]
        tip[6 + j] = last[5 + 3 * j] + actuation[6 + j, 0]
    return _respond(rod, work, displacement_driven, loads, jacobian, level, geometry, actuation, force) and solvable


@inlined
def _respond(
    rod: RodData, work: Work, displacement_driven: bool, loads: Any, jacobian: Any, levels: Any, geometry: Any,
    actuation: Any, force: Any,
) -> bool:  # fmt: skip
    """Fill `actuation` and `force` from the equations' Jacobian and the tip's (`work.tip`); False where singular."""
    n = len(rod.x)
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
        if column < n:
            _follow(work, last, strain, m, direct, actuation, column)
        else:
            _follow(work, last, strain, m, direct, force, column - n)
    return solvable


@inlined
def _follow(work: Work, last: Any, strain: Any, m: int, direct: int, target: Any, at: int) -> None:
    """Column `at` of `target`: how position, velocity and direction of the tip change with the unknowns.

    These change by `work.step`, and the unknown `direct` by one beside them; -1: none.
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
        target[6 + j, at] = work.node[5 + 3 * j]
