"""A path of the whole model through a stretch, and its linear model for small deviations."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from tendond.model.errors import ConvergenceError
from tendond.model.estimation.kalman.estimator import STIFFNESS_MAX, Estimator
from tendond.model.estimation.kalman.memory import Expected, Reading, Taken
from tendond.model.estimation.kalman.state import EstimatorState
from tendond.model.estimation.kalman.taking import labels_of, small_rotation
from tendond.model.rods.general import GeneralState
from tendond.model.rods.stations import BodyLoads
from tendond.offline.smoothing.linear import Line, Problem
from tendond.offline.smoothing.stretches import Stretch

Array = NDArray[np.float64]


OTHER_CAUSES = 0.02
"""Distance of a resting tip from the model's that needs no load, in lengths: wrong tensions and stiffness. Chosen."""


TURNS = 3
"""Solutions for a rest under moments, which turn with the robot: each is nearer by as much as they change its shape."""


@dataclass(frozen=True)
class Path:
    """The model at each instant, K of them.

    Attributes:
        states: before the step of the instant. stepped: after it, before it is moved to the next one's place; K - 1.
        errors: followed strains and rates, then force, errors of tensions, moments, stiffness and tip mass, (K, N).
    """

    states: Sequence[GeneralState]
    stepped: Sequence[GeneralState]
    errors: Array


class PathModel:
    """What moves along a stretch: the model, with the errors that the estimator follows.

    Args:
        estimator: of the robot. stretch: tensions and measurements.

    Attributes:
        estimator: as given. stretch: as given. rest: the model before the first instant. start: the estimator there.
        causes: places of force and errors of tensions, moments, stiffness and mass. decay: of these, (N - 2 k,).

    Raises:
        ConvergenceError: the model has no rest.
    """

    def __init__(self, estimator: Estimator, stretch: Stretch) -> None:
        self.estimator, self.stretch = estimator, stretch
        load = load_at_rest(estimator, stretch)
        self.rest = estimator.rod.solve_static(stretch.before, tip_force=load)
        self.start = estimator.start(self.rest, load)
        errors = estimator.errors
        self.causes = slice(errors.rate.stop, errors.size)
        self.decay = estimator.filter.decay

    def vector(self, state: GeneralState, estimate: EstimatorState) -> Array:
        """Return the followed strains and rates of a state, then the causes as estimated, shape (N,)."""
        kept, strain = self.estimator.errors.kept, state.strain
        causes = (estimate.force, estimate.tension_error, estimate.bend_error, [estimate.stiffness_error])
        mass = [estimate.tip_mass] * (self.estimator.noise.tip_mass > 0.0)
        return np.concatenate((strain.strain[kept], strain.rate[kept], *causes, mass))

    def estimate(self, errors: Array) -> EstimatorState:
        """Return the estimator's state with these causes; `errors`: shape (N,)."""
        layout = self.estimator.errors
        return replace(
            self.start,
            force=errors[layout.force],
            tension_error=errors[layout.tension],
            bend_error=errors[layout.bend],
            stiffness_error=float(errors[layout.stiffness]),
            tip_mass=layout.tip_mass_of(errors),
        )

    def follow(self, errors: Array) -> Path:
        """Return the path on which the followed errors are those given, and the finer modes follow them.

        Args:
            errors: see `Path`; a stiffness or a mass beyond what is believed is brought back.

        Raises:
            ConvergenceError: the model has no solution on it.
        """
        layout = self.estimator.errors
        errors = errors.copy()
        errors[:, layout.stiffness] = np.clip(errors[:, layout.stiffness], -STIFFNESS_MAX, STIFFNESS_MAX)
        least = self.estimator.rod.tip_load.least
        errors[:, layout.tip_mass] = np.maximum(errors[:, layout.tip_mass], least)
        states, stepped = [self._moved(self.rest, errors[0])], []
        for instant, here, there in zip(self.stretch.instants, errors, errors[1:], strict=False):
            stepped.append(self.estimator.step(self.estimate(here), states[-1], instant.tensions))
            states.append(self._moved(stepped[-1], there))
        return Path(states, stepped, errors)

    def _moved(self, state: GeneralState, errors: Array) -> GeneralState:
        rod, layout = self.estimator.rod, self.estimator.errors
        strain, rate = np.zeros((2, rod.strain_rod.modes))
        strain[layout.kept] = errors[layout.strain] - state.strain.strain[layout.kept]
        rate[layout.kept] = errors[layout.rate] - state.strain.rate[layout.kept]
        return rod.moved(state, strain, rate, 1.0 + float(errors[layout.stiffness]), layout.tip_mass_of(errors))

    def problem(self, path: Path) -> Problem:
        """Return the linear model of deviations from a path."""
        lines = [self._line(path, k) for k in range(len(path.stepped))]
        mean, covariance = self.prior(path.errors[0])
        groups = [one.group for one in self.estimator.sensors]
        return Problem(mean - path.errors[0], covariance, lines, self.taken(path), groups, self.estimator.errors.force)

    def rest_under(self, errors: Array) -> GeneralState:
        """Return the model at rest before the first instant, under the causes among the errors, shape (N,).

        Raises:
            ConvergenceError: it has no rest there.
        """
        rod, estimate = self.estimator.rod, self.estimate(errors)
        state = replace(self.rest, stiffness=1.0 + estimate.stiffness_error, tip_mass=estimate.tip_mass)
        rod.use(state)
        pulls, inner = estimate.acting(self.stretch.before), self.estimator.errors.inner_moments(estimate.bend_error)
        for _ in range(TURNS):
            body = BodyLoads(rod.backbone.turned(state.strain, inner), np.zeros((len(rod.stations.at), 3)))
            strain = rod.strain_rod.solve_static(rod.loads(pulls, estimate.force, body), state.strain)
            state = replace(state, strain=strain, tensions=pulls, tip_force=estimate.force, body=body)
        return state

    def prior(self, errors: Array) -> tuple[Array, Array]:
        """Return mean and covariance of the errors at the first instant before any measurement, (N,) and (N, N).

        Causes are assumed about zero, and the robot to rest under them: by the linear model of the rest under those of
        `errors`, shape (N,).
        """
        rest = self.rest_under(errors)
        covariance = self.estimator.start(rest).moments[0].factors.covariance
        variance = np.diag(covariance)[self.causes]
        by_causes = covariance[:, self.causes] / np.where(variance > 0.0, variance, np.inf)
        mean = self.vector(rest, self.start) - by_causes @ errors[self.causes]
        mean[self.causes] = 0.0
        return mean, covariance

    def _line(self, path: Path, k: int) -> Line:
        """Return the linear model of a step."""
        before, after, here, there = path.states[k], path.stepped[k], path.errors[k], path.errors[k + 1]
        known = self.estimator.filter
        top, noise = known.transition(before, after), known.step_noise(after.tensions)
        reached = self.vector(after, self.estimate(here))
        reached[self.causes] *= self.decay
        return Line(top, self.decay, reached - there, noise)

    def taken(self, path: Path) -> list[list[Taken]]:
        """Return the measurements at each instant, against the path."""
        expected = [self._expected(state) for state in path.states]
        found: list[list[Taken]] = [[] for _ in path.states]
        for i, instant in enumerate(self.stretch.instants):
            for reading in instant.readings:
                back = min(max(reading.age, 0.0) / self.estimator.rod.time_step, float(i))
                whole = math.floor(back)
                later, earlier = expected[i - whole], expected[max(0, i - whole - 1)]
                lack = _lack(reading, later[reading.sensor])
                lack = lack + (back - whole) * (_lack(reading, earlier[reading.sensor]) - lack)
                seen, at = np.isfinite(lack), i - round(back)
                variance = self.estimator.sensors[reading.sensor].deviation ** 2
                rows = expected[at][reading.sensor].rows
                labels = labels_of(reading, expected[at][reading.sensor], np.flatnonzero(seen))
                found[at].append(Taken(rows[seen], lack[seen], variance[seen], reading.sensor, labels))
        return found

    def _expected(self, state: GeneralState) -> list[Expected]:
        estimator = self.estimator
        return [sensor.expect(estimator.rod, estimator.errors, state) for sensor in estimator.sensors]


def load_at_rest(estimator: Estimator, stretch: Stretch) -> Array:
    """Return the force on the tip under which the model would rest where the first pose is [N], shape (3,).

    No more of it than the distance asks for. It is where the estimator starts: from a rest that is far from the robot's
    its linear model may not get there.
    """
    poses = (one.value for instant in stretch.instants for one in instant.readings if one.sensor == 0)
    seen, rod, none = next(poses, None), estimator.rod, np.zeros(3)
    if seen is None:
        return none

    def misfit(force: Array) -> Array:
        place = rod.solve_static(stretch.before, tip_force=force).position
        return np.concatenate(((place - seen) / (OTHER_CAUSES * rod.robot.length), force / estimator.noise.load_start))

    try:
        return np.asarray(least_squares(misfit, none, x_scale=estimator.noise.load_start, diff_step=[1e-4]).x)
    except ConvergenceError:
        return none


def _lack(reading: Reading, expected: Expected) -> Array:
    """Measured minus expected."""
    lack = reading.value - expected.value
    if reading.rotation is not None and expected.rotation is not None and len(expected.rows) > 3:
        lack = np.concatenate((lack, small_rotation(reading.rotation @ expected.rotation.T)))
    return np.asarray(lack)
