"""Time that the filter takes in a cycle, beside the model's own step."""

import time
from dataclasses import dataclass, replace

import numpy as np

from tendond.model.estimation.kalman.estimator import Estimator
from tendond.model.estimation.kalman.memory import Reading
from tendond.model.rods.general import GeneralRod
from tendond.model.strain.robot import Robot
from tendond.offline.estimator.runs import PERIOD, noise_for

CYCLES = 400


@dataclass(frozen=True)
class Cost:
    """Median times of a cycle [us].

    Attributes:
        robot: name. errors: numbers that the filter follows.
        step: of the model. filter: of correction and prediction.
    """

    robot: str
    errors: int
    step: float
    filter: float


def in_sections(robot: Robot, count: int) -> Robot:
    """Return a robot of so many sections like the first one, each with tendons to its end."""
    section = robot.sections[0]
    tendons = tuple(
        replace(one, end=(number + 1) * section.length) for number in range(count) for one in robot.tendons[:3]
    )
    return replace(robot, sections=(section,) * count, tendons=tendons, bodies=())


def cost_of(name: str, robot: Robot, age: float = 0.0) -> Cost:
    """Return the times of a robot's filter with one pose a cycle; `age`: of it [s]."""
    rod = GeneralRod(robot, PERIOD)
    estimator = Estimator(rod, noise_for(robot), age_max=age)
    pulls = np.full(len(robot.tendons), 0.2)
    state = rod.solve_static(pulls)
    estimate, steps, rest = estimator.start(state), [], []
    position, turn = state.position, rod.strain_rod.tip(state.strain)[1]
    for _ in range(CYCLES):
        begun = time.perf_counter()
        estimate, state = estimator.correct(estimate, state, [Reading(0, age, position, turn)])
        corrected = time.perf_counter()
        after = estimator.step(estimate, state, pulls)
        stepped = time.perf_counter()
        estimate, state = estimator.advance(estimate, state, after), after
        ended = time.perf_counter()
        steps.append(stepped - corrected)
        rest.append(corrected - begun + ended - stepped)
    return Cost(name, estimator.errors.size, 1e6 * float(np.median(steps)), 1e6 * float(np.median(rest)))
