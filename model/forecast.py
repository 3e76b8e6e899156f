"""Where the tip will be after the coming step, and how that answers to the tendons: linearised, before the step."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model.compile import kernel
from tendond.model.predictor import predict
from tendond.model.sensitivity import Sensitivity, follow, respond
from tendond.model.shooting import RodData, differentiate, evaluate, newton_step
from tendond.model.timestep import step_history
from tendond.model.work import open_work

Array = NDArray[np.float64]

CORRECTIONS = 2
"""Marches of a forecast beside the one at the first guess."""


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
    follow(work, last, strain, m, -1, actuation, 0)
    for j in range(3):
        velocity = 0.0
        for k in range(3):
            velocity += last[3 + 3 * j + k] * strain[6 + k]
        tip[j] = last[j] + actuation[j, 0]
        tip[3 + j] = velocity + actuation[3 + j, 0]
        tip[6 + j] = last[5 + 3 * j] + actuation[6 + j, 0]
    return respond(rod, work, displacement_driven, loads, jacobian, level, geometry, actuation, force) and solvable
