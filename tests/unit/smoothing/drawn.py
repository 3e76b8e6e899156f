"""Motions of the model whose errors are drawn from what the estimator assumes of them."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tendond.model.estimation.kalman.estimator import Estimator
from tendond.model.estimation.kalman.memory import Reading
from tendond.model.estimation.kalman.noise import noise_of
from tendond.model.rods.general import GeneralRod
from tendond.model.strain.describe.configured import described
from tendond.offline.smoothing.path import Path, PathModel
from tendond.offline.smoothing.stretches import Instant, Stretch

Array = NDArray[np.float64]

PERIOD = 0.01


@dataclass(frozen=True)
class Drawn:
    """model: along a stretch with measurements; truth: the path that was measured."""

    model: PathModel
    truth: Path


def estimator_of(preset: str = "paper", age_max: float = 0.0) -> Estimator:
    """Return the estimator of a robot, with a camera's noise."""
    robot, _ = described(preset)
    rod = GeneralRod(robot, PERIOD)
    return Estimator(rod, noise_of(rod.parameters, 1e-4, 5e-3, 0.1, 3.0, 0.1), age_max=age_max)


def tensions_of(estimator: Estimator, cycles: int, rng: np.random.Generator) -> Array:
    """Return tensions that rise and fall, each with a period of its own [N]; none is slack, from the start on."""
    rod = estimator.rod.parameters
    unit = rod.bending_stiffness / (rod.length * max(float(np.hypot(*place)) for place in rod.tendon_positions))
    count = len(rod.tendon_positions)
    periods, phases = rng.uniform(0.5, 2.0, count), rng.uniform(0.0, 2.0 * np.pi, count)
    time = PERIOD * np.arange(cycles)[:, None]
    return np.asarray(unit * (0.3 + 0.2 * np.sin(2.0 * np.pi * time / periods + phases)))


def first_errors(still: PathModel, tensions: Array, rng: np.random.Generator) -> Array:
    """Draw causes, and the shape in which the robot rests under them, but for what it may be wrong by."""
    estimator, layout = still.estimator, still.estimator.errors
    rod, noise = estimator.rod, estimator.noise
    factors = still.start.moments[0].factors
    errors = still.vector(still.rest, still.start)
    errors[still.causes] = np.sqrt(np.diag(factors.covariance)[still.causes]) * rng.normal(size=len(still.decay))
    state = still.rest_under(errors)
    order = rod.strain_rod.layout.order[layout.kept]
    unknown = noise.shape / (1.0 + order) / rod.robot.length
    errors[layout.strain] = state.strain.strain[layout.kept] + unknown * rng.normal(size=len(order))
    return errors


def drawn(estimator: Estimator, tensions: Array, rng: np.random.Generator, late: int = 0) -> Drawn:
    """Draw a motion under these tensions, and poses of it that are `late` periods old when they arrive."""
    still = PathModel(
        estimator, Stretch(tuple(Instant(i, 0.0, pull, ()) for i, pull in enumerate(tensions)), tensions[0])
    )
    errors, states, stepped = [first_errors(still, tensions[0], rng)], [], []
    states.append(still.follow(np.array(errors)).states[0])
    for pull in tensions[:-1]:
        after = estimator.step(still.estimate(errors[-1]), states[-1], pull)
        noise = estimator.advance(still.start, states[-1], after).moments[0].noise
        assert noise is not None
        ahead = still.vector(after, still.estimate(errors[-1]))
        ahead[still.causes] = still.decay * ahead[still.causes] + np.sqrt(noise) * rng.normal(size=len(noise))
        errors.append(ahead)
        states.append(replace(after, stiffness=1.0 + float(errors[0][-1])))
        stepped.append(after)
    deviation = estimator.sensors[0].deviation
    instants = []
    for i, pull in enumerate(tensions):
        readings: tuple[Reading, ...] = ()
        if i >= late:
            place, turn = estimator.rod.strain_rod.tip(states[i - late].strain)
            turned = Rotation.from_rotvec(rng.normal(0.0, deviation[3:])).as_matrix() @ turn
            readings = (Reading(0, late * PERIOD, place + rng.normal(0.0, deviation[:3]), turned),)
        instants.append(Instant(i, i * PERIOD, pull, readings))
    model = PathModel(estimator, Stretch(tuple(instants), tensions[0]))
    return Drawn(model, Path(states, stepped, np.array(errors)))
