"""The robot of these tests, its estimator, and what a camera sees of it."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tendond.model.estimation.kalman.estimator import Estimator
from tendond.model.estimation.kalman.memory import Reading
from tendond.model.estimation.kalman.noise import noise_of
from tendond.model.estimation.kalman.sensors import Sensor
from tendond.model.rods.general import GeneralRod, GeneralState
from tendond.model.strain.describe.configured import described

Array = NDArray[np.float64]

ROBOT = described("paper")[0]
SLACK = np.zeros(len(ROBOT.tendons))
PERIOD = 0.01
POSITION, ORIENTATION = 1e-4, 2e-3


def rod(friction: float = 0.0) -> GeneralRod:
    return GeneralRod(replace(ROBOT, tendons=tuple(replace(one, friction=friction) for one in ROBOT.tendons)), PERIOD)


def estimator_of(model: GeneralRod, *sensors: Sensor, age_max: float = 0.0, **changes: float) -> Estimator:
    noise = noise_of(model.parameters, POSITION, ORIENTATION, 0.07, 3.0, 0.1)
    return Estimator(model, replace(noise, **changes), sensors, age_max)


def pose_of(plant: GeneralRod, state: GeneralState, age: float = 0.0, noise: Array | None = None) -> Reading:
    position, turn = plant.strain_rod.tip(state.strain)
    return Reading(0, age, position if noise is None else position + noise, turn)
