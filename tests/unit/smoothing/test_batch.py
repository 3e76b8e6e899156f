"""The smoother against nonlinear least squares over a whole motion: all unknowns at once, by the model's own steps."""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from tendond.model.estimation.kalman.factored import factors_of
from tendond.model.rods.stations import BodyLoads
from tendond.offline.smoothing.passes import smooth_stretch
from tests.unit.smoothing.drawn import drawn, estimator_of, tensions_of

Array = NDArray[np.float64]

CYCLES, LATE = 16, 2

AGREES = 0.05
"""Largest difference, in standard deviations: the smoother's derivatives are not exact, see `passes`."""


def test_the_path_is_that_of_nonlinear_least_squares_over_all_unknowns() -> None:
    estimator, rng = estimator_of(age_max=0.02), np.random.default_rng(3)
    one = drawn(estimator, tensions_of(estimator, CYCLES, rng), rng, LATE)
    smoothed = smooth_stretch(estimator, one.model.stretch)
    model, rod, errors = smoothed.model, estimator.rod, estimator.errors
    start, covariance = model.prior(smoothed.path.errors[0])
    factors = factors_of(covariance)
    root = factors.columns.T * np.sqrt(factors.spread)
    spreads = [np.sqrt(line.noise[:-1]) for line in smoothed.problem.lines]  # the stiffness stays
    deviation = estimator.sensors[0].deviation

    def path_of(unknown: Array) -> tuple[list[Array], Array]:
        """Roll the model out from the unknowns, in their standard deviations; return its states and the misfits."""
        n = len(start)
        first, rest = start + root @ unknown[:n], unknown[n:].reshape(CYCLES - 1, -1)
        strain, rate = np.zeros((2, rod.strain_rod.modes))
        strain[errors.kept] = first[errors.strain] - model.rest.strain.strain[errors.kept]
        rate[errors.kept] = first[errors.rate]
        state = rod.moved(model.rest, strain, rate, 1.0 + first[-1])
        causes, found, tips = first[2 * len(errors.kept) : -1].copy(), [], []
        for i, instant in enumerate(model.stretch.instants):
            kept = (state.strain.strain[errors.kept], state.strain.rate[errors.kept])
            found.append(np.concatenate((*kept, causes, first[-1:])))
            tips.append(rod.strain_rod.tip(state.strain))
            if i < CYCLES - 1:
                force, tension, bend = np.split(causes, (3, 3 + len(rod.robot.tendons)))
                moments = rod.backbone.turned(state.strain, errors.inner_moments(bend))
                body = BodyLoads(moments, np.zeros((len(rod.stations.at), 3)))
                state = rod.step_bent(state, instant.tensions + tension, force, body)
                causes = causes * np.exp(
                    [0.0] * 3 + [-rod.time_step / estimator.noise.tension_time] * (len(causes) - 3)
                )
                causes = causes + spreads[i] * rest[i]
        misfits = [unknown]
        for i, instant in enumerate(model.stretch.instants[LATE:]):
            (reading,), (place, turn) = instant.readings, tips[i]
            assert reading.rotation is not None
            turned = Rotation.from_matrix(reading.rotation @ turn.T).as_rotvec()
            misfits.append(np.concatenate((reading.value - place, turned)) / deviation)
        return found, np.concatenate(misfits)

    def jacobian(unknown: Array) -> Array:
        """Differences by a thousandth of a standard deviation."""
        here = path_of(unknown)[1]
        return np.array([(path_of(unknown + d)[1] - here) / 1e-3 for d in 1e-3 * np.eye(len(unknown))]).T

    def misfits_of(unknown: Array) -> Array:
        return path_of(unknown)[1]

    count = len(start) + sum(map(len, spreads))
    solved = least_squares(misfits_of, np.zeros(count), jacobian, xtol=1e-6, ftol=1e-8)
    likeliest = np.array(path_of(solved.x)[0])
    spread = np.sqrt(np.einsum("kii->ki", smoothed.found.covariance))
    apart = np.abs(smoothed.path.errors - likeliest)
    assert (apart <= AGREES * spread + 1e-9).all()  # the rates at the start are zero
    assert abs(2.0 * solved.cost / smoothed.found.square - 1.0) < 1e-3
    # The spread of the last force, by all second derivatives at the least squares.
    by_unknown = np.array([path_of(solved.x + d)[0][-1][errors.force] for d in 1e-3 * np.eye(len(solved.x))])
    by_unknown = (by_unknown - likeliest[-1, errors.force]) / 1e-3
    there = jacobian(solved.x)
    covariance = by_unknown.T @ np.linalg.solve(there.T @ there, by_unknown)
    np.testing.assert_allclose(spread[-1, errors.force], np.sqrt(np.diag(covariance)), rtol=0.05)
