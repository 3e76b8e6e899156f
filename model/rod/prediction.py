"""Predict the tip after the coming step, and its jacobian by the tendons: linearised, before the step."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import borrowed, inlined, kernel
from tendond.model.numerics.linear import solve_in_place
from tendond.model.rod.sensitivity import tip_derivative
from tendond.model.solver.lanes import STATE
from tendond.model.solver.march import march
from tendond.model.solver.predictor import predict
from tendond.model.solver.problem import Bdf, Problem, Profile, RodData, StateData, borrowed_rod, borrowed_state
from tendond.model.solver.shooting import change, evaluate, perturb, perturbation, spread
from tendond.model.solver.timestep import step_history
from tendond.model.solver.work import LANES, Work, open_work

Array = NDArray[np.float64]

CORRECTIONS = 2
"""Marches of a prediction beside the one at the first guess."""

INPUTS = LANES - 6
"""Combinations of tensions: with the six base loads they fill the lanes of one march."""


@dataclass(frozen=True)
class TipPrediction:
    """The tip after the coming step of a tension-driven rod, world frame, under the given loads.

    Attributes:
        position, velocity, direction: [m], [m/s], [-], shape (3,).
        position_jacobian, direction_jacobian: derivatives by each combination of tensions, shape (3, 2).
    """

    position: Array
    velocity: Array
    direction: Array
    position_jacobian: Array
    direction_jacobian: Array


class PredictionScratch(NamedTuple):
    """Memory of a prediction that is not the rod's own."""

    history: Any  # shape (stages, 18)
    profile: Profile
    jacobian: Any  # of the residual at the tip by base loads and combinations, shape (6, 8)


@kernel
def predict_tip(
    rod: RodData, memory: Any, bdf: Bdf, state: StateData, loads: Any, inputs: Any, scratch: PredictionScratch,
    tip: Any,
    tip_jacobian: Any,
) -> bool:  # fmt: skip
    """Fill `tip`, shape (9,), with position, velocity, direction after the next step; and its jacobian, shape (9, 2).

    The step's equations are linearised at its first guess; its error in a fast motion is corrected
    by a march or two with the same Jacobian. False where they are singular.

    Args:
        rod, memory: the rod and its scratch memory.
        bdf: bdf of the time step.
        state: before the step.
        loads: loads of the step, shape (n + 15,).
        inputs: combinations of tensions, in each row the tensions per unit of one, shape (2, n).
        scratch, tip, tip_jacobian: written.
    """
    n = rod.tendons
    rod, state, work = borrowed_rod(rod), borrowed_state(state), open_work(borrowed(memory), rod)
    step_history(bdf, state, scratch.history)
    problem, profile, jacobian = Problem(bdf[0], False, loads, scratch.history), scratch.profile, scratch.jacobian
    unknown, node = work.last, work.shots.node
    predict(state.unknowns, state.step, work.scale, work.differences, 6, unknown)
    for i in range(n):
        unknown[6 + i] = loads[i]
    evaluate(rod, work, problem, unknown, profile, work.raw)
    for j in range(STATE):
        for column in range(LANES):
            work.tip[j, column] = node[j]
    _differentiate(rod, work, problem, unknown, inputs, profile, jacobian)
    solvable = True
    for more in range(CORRECTIONS, -1, -1):
        if more < CORRECTIONS:
            evaluate(rod, work, problem, unknown, profile, work.raw)
        for j in range(6):
            work.step[j] = -work.raw[j]
        solvable = _solve(work, jacobian) and solvable
        if more > 0:
            for j in range(6):
                unknown[j] += work.step[j]
    last, strain = profile.geometry[profile.geometry.shape[0] - 1], profile.levels[profile.levels.shape[0] - 1]
    tip_derivative(work, last, strain, 6, -1, tip_jacobian, 0)
    for j in range(3):
        velocity = 0.0
        for k in range(3):
            velocity += last[3 + 3 * j + k] * strain[6 + k]
        tip[j] = last[j] + tip_jacobian[j, 0]
        tip[3 + j] = velocity + tip_jacobian[3 + j, 0]
        tip[6 + j] = last[5 + 3 * j] + node[5 + 3 * j]
    for column in range(INPUTS):
        for j in range(6):
            work.step[j] = -jacobian[j, 6 + column]
        solvable = _solve(work, jacobian) and solvable
        tip_derivative(work, last, strain, 6, 6 + column, tip_jacobian, column)
        for j in range(3):
            tip_jacobian[6 + j, column] = node[5 + 3 * j]
    return solvable


@inlined
def _solve(work: Work, jacobian: Any) -> bool:
    """Solve for the change of the base loads that makes up for the residual `work.step`, in its place."""
    for j in range(6):
        for k in range(6):
            work.matrix[j, k] = jacobian[j, k]
    return bool(solve_in_place(work.matrix, work.step, 6))


@inlined
def _differentiate(
    rod: RodData, work: Work, problem: Problem, unknown: Any, inputs: Any, profile: Profile, jacobian: Any
) -> None:
    """Derivatives of the tip's residual, and of its state, by each base load and combination; in one march."""
    shots = work.shots
    spread(rod, work, unknown)
    for j in range(6):
        perturb(work, j, j, perturbation(work, unknown, j))
    for lane in range(6, LANES):
        step = _input_step(rod, work, unknown, inputs, lane - 6)
        for i in range(rod.tendons):
            perturb(work, 6 + i, lane, step * inputs[lane - 6, i])
    march(rod.many, rod, problem, shots, profile)
    for lane in range(LANES):
        step = perturbation(work, unknown, lane) if lane < 6 else _input_step(rod, work, unknown, inputs, lane - 6)
        inverse = 1.0 / step
        for j in range(6):
            jacobian[j, lane] = change(shots.residual, j, lane, work.raw[j]) * inverse
        for j in range(STATE):
            work.tip[j, lane] = change(shots.node, j, lane, work.tip[j, lane]) * inverse


@inlined
def _input_step(rod: RodData, work: Work, unknown: Any, inputs: Any, row: int) -> float:
    """Difference step of a combination: that of the tension which it changes by the largest amount."""
    largest = 0
    for i in range(rod.tendons):
        if abs(inputs[row, i]) > abs(inputs[row, largest]):
            largest = i
    return float(perturbation(work, unknown, 6 + largest) / abs(inputs[row, largest]))
