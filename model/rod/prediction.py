"""Where the tip will be after the coming step, and how that answers to the tendons: linearised, before the step."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, kernel
from tendond.model.numerics.linear import solve_in_place
from tendond.model.rod.sensitivity import follow
from tendond.model.solver.march import STATE, march
from tendond.model.solver.predictor import predict
from tendond.model.solver.shooting import RodData, evaluate, perturbation
from tendond.model.solver.timestep import step_history
from tendond.model.solver.work import LANES, Work, open_work

Array = NDArray[np.float64]

CORRECTIONS = 2
"""Marches of a forecast beside the one at the first guess."""

WAYS = LANES - 6
"""Ways to pull: with the six base loads they fill the lanes of one march."""


@dataclass(frozen=True)
class TipPrediction:
    """The tip after the coming step of a tension-driven rod, world frame, if the loads are as they were given.

    Attributes:
        position, velocity, direction: [m], [m/s], [-], shape (3,).
        position_jacobian, direction_jacobian: how they answer to each way to pull, shape (3, 2).
    """

    position: Array
    velocity: Array
    direction: Array
    position_jacobian: Array
    direction_jacobian: Array


@kernel
def predict_tip(
    rod: RodData, memory: Any, bdf: tuple[float, float, float, float], count: int, levels: Any, histories: Any,
    unknowns: Any, loads: Any, ways: Any, history: Any, level: Any, geometry: Any, jacobian: Any, tip: Any, answer: Any,
) -> bool:  # fmt: skip
    """Fill `tip`, shape (9,), with position, velocity, direction after the next step; `answer`, shape (9, 2), per way.

    The step's equations are linearised at its first guess; what that misses when the motion changes fast, a march or
    two with the same Jacobian put right. False where they are singular.

    Args:
        levels, histories, unknowns: rings, see `timestep.advance`.
        ways: tensions that change together, per unit of a way, shape (2, n).
        history, level, geometry, jacobian: scratch; the last of shape (6, 8).
    """
    n, c0 = len(rod.x), bdf[0]
    work = open_work(memory, n)
    step_history(bdf, count, levels, histories, history)
    unknown = work.last
    predict(unknowns, count, work.scale, work.differences, 6, unknown)
    for i in range(n):
        unknown[6 + i] = loads[i]
    evaluate(rod, work, c0, unknown, loads, history, level, geometry, work.raw)
    for j in range(STATE):
        for column in range(LANES):
            work.tip[j, column] = work.node[j]
    _differentiate(rod, work, c0, unknown, loads, ways, history, level, geometry, jacobian)
    solvable = True
    for more in range(CORRECTIONS, -1, -1):
        if more < CORRECTIONS:
            evaluate(rod, work, c0, unknown, loads, history, level, geometry, work.raw)
        for j in range(6):
            work.step[j] = -work.raw[j]
        solvable = _solve(work, jacobian) and solvable
        if more > 0:
            for j in range(6):
                unknown[j] += work.step[j]
    last, strain = geometry[geometry.shape[0] - 1], level[level.shape[0] - 1]
    follow(work, last, strain, 6, -1, answer, 0)
    for j in range(3):
        velocity = 0.0
        for k in range(3):
            velocity += last[3 + 3 * j + k] * strain[6 + k]
        tip[j] = last[j] + answer[j, 0]
        tip[3 + j] = velocity + answer[3 + j, 0]
        tip[6 + j] = last[5 + 3 * j] + work.node[5 + 3 * j]
    for way in range(WAYS):
        for j in range(6):
            work.step[j] = -jacobian[j, 6 + way]
        solvable = _solve(work, jacobian) and solvable
        follow(work, last, strain, 6, 6 + way, answer, way)
        for j in range(3):
            answer[6 + j, way] = work.node[5 + 3 * j]
    return solvable


@inlined
def _solve(work: Work, jacobian: Any) -> bool:
    """The base loads' change for what `work.step` says is missing, in its place."""
    for j in range(6):
        for k in range(6):
            work.matrix[j, k] = jacobian[j, k]
    return bool(solve_in_place(work.matrix, work.step, 6))


@inlined
def _differentiate(
    rod: RodData, work: Work, c0: float, unknown: Any, loads: Any, ways: Any, history: Any, level: Any, geometry: Any,
    jacobian: Any,
) -> None:  # fmt: skip
    """What the tip's residual does with each base load and each way to pull, and the tip's state; in one march."""
    n = len(rod.x)
    for lane in range(LANES):
        for j in range(6):
            work.base[j * LANES + lane] = unknown[j]
        for i in range(n):
            work.tension[i * LANES + lane] = unknown[6 + i]
            if lane >= 6:
                work.tension[i * LANES + lane] += _stride(rod, work, unknown, ways, lane - 6) * ways[lane - 6, i]
    for j in range(6):
        work.base[j * LANES + j] += perturbation(work, unknown, j)
    march(
        rod.many, rod.x, rod.y, rod.constants, rod.tableau, rod.weights, rod.flags, rod.steps, rod.ds, c0, work.base,
        work.tension, loads[n:], rod.push, history, level, geometry, work.march, work.node, work.length, work.residual,
    )  # fmt: skip
    for lane in range(LANES):
        step = perturbation(work, unknown, lane) if lane < 6 else _stride(rod, work, unknown, ways, lane - 6)
        for j in range(6):
            jacobian[j, lane] = (work.residual[j * LANES + lane] - work.raw[j]) / step
        for j in range(STATE):
            work.tip[j, lane] = (work.node[j * LANES + lane] - work.tip[j, lane]) / step


@inlined
def _stride(rod: RodData, work: Work, unknown: Any, ways: Any, way: int) -> float:
    """Difference step of a way: that of the tension which it changes most."""
    most = 0
    for i in range(len(rod.x)):
        if abs(ways[way, i]) > abs(ways[way, most]):
            most = i
    return float(perturbation(work, unknown, 6 + most) / abs(ways[way, most]))
