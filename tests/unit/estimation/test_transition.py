"""The linear model of the errors against the rod's own exact derivatives, and against differences."""

from dataclasses import replace

import numpy as np
import pytest

from tendond.model.rods.general import GeneralRod
from tendond.model.rods.stations import BodyLoads
from tendond.model.strain.derivatives.linearise import Linearisation
from tendond.model.strain.robot import Body
from tests.unit.estimation.robots import PERIOD, ROBOT, estimator_of, rod

PULLED = np.array([5.0, 0.5, 2.0, 1.0])


def test_at_rest_it_is_the_exact_one_and_in_motion_nearly() -> None:
    model = rod()
    estimator = estimator_of(model)
    errors, n = estimator.errors, model.strain_rod.modes
    linear = Linearisation(model.strain_rod)
    kept = np.concatenate((errors.kept, n + errors.kept))
    state = model.solve_static(PULLED)
    for tolerance in (5e-3, 0.03):
        top = estimator.filter.transition(state, model.step(state, PULLED))
        exact = linear.step(state.strain, model.loads(PULLED))
        for own, right in (
            (top[:, : errors.force.start], exact.a[np.ix_(kept, kept)]),
            (top[:, errors.force], exact.by_force[kept]),
            (top[:, errors.tension], exact.b[kept]),
        ):
            assert own == pytest.approx(right, abs=tolerance * np.abs(right).max())
        for _ in range(3):  # then it moves
            state = model.step(state, 0.5 * PULLED)


def test_moments_and_stiffness_move_the_model_as_their_columns_say() -> None:
    model = rod()
    estimator = estimator_of(model)
    errors = estimator.errors
    state = model.solve_static(PULLED)
    top = estimator.filter.transition(state, model.step(state, PULLED))
    size = 1e-4
    for index in range(len(errors.bends)):
        bend = np.zeros(len(errors.bends))
        bend[index] = size
        moments = model.backbone.turned(state.strain, errors.inner_moments(bend))
        bodies = [BodyLoads(sign * moments, np.zeros((len(model.stations.at), 3))) for sign in (1.0, -1.0)]
        moved = [model.step_bent(state, PULLED, np.zeros(3), body).strain.strain for body in bodies]
        column = (moved[0] - moved[1])[errors.kept] / (2.0 * size)
        own = top[: len(errors.kept), errors.bend.start + index]
        assert own == pytest.approx(column, abs=0.06 * np.abs(column).max())
    nothing = np.zeros(model.strain_rod.modes)
    ends = [
        model.step(model.moved(state, nothing, nothing, 1.0 + sign * size), PULLED).strain.strain
        for sign in (1.0, -1.0)
    ]
    column = (ends[0] - ends[1])[errors.kept] / (2.0 * size)
    assert top[: len(errors.kept), errors.stiffness] == pytest.approx(column, abs=0.01 * np.abs(column).max())


def test_a_mass_on_the_tip_moves_the_model_as_its_column_says() -> None:
    tool = replace(ROBOT, bodies=(*ROBOT.bodies, Body(ROBOT.length, 0.02, offset=(0.0, 0.0, 0.03))))
    for robot in (ROBOT, tool):
        model = GeneralRod(robot, PERIOD)
        estimator = estimator_of(model, tip_mass=0.02)
        errors, states = estimator.errors, [model.solve_static(PULLED)]
        for tick in range(40):
            states.append(model.step(states[-1], PULLED * (1.0 + 0.3 * np.sin(0.1 * tick))))
        before, pulls, more = states[-1], states[-1].tensions, 1e-4
        after = model.step(before, pulls)
        heavier = model.step(replace(before, tip_mass=more), pulls)
        column = (heavier.strain.strain - after.strain.strain)[errors.kept] / more
        own = estimator.filter.transition(before, after)[: len(errors.kept), -1]
        assert own == pytest.approx(column, abs=0.1 * np.abs(column).max())


def test_what_accelerates_the_model_alone_tells_no_mass() -> None:
    """A state that is uncertain accelerates it: then the weight is left in the column."""
    model = rod()
    estimator = estimator_of(model, tip_mass=0.02)
    rest = model.solve_static(PULLED)
    before = model.moved(rest, np.full(model.strain_rod.modes, 1e-3), np.zeros(model.strain_rod.modes), 1.0)
    after = model.step(before, PULLED)
    still = estimator.filter.transition(rest, model.step(rest, PULLED))[:, -1]
    sure = estimator.filter.transition(before, after)[:, -1]
    unsure = estimator.filter.transition(before, after, estimator.start(rest).moments[0].factors)[:, -1]
    assert np.abs(unsure - still).max() < 0.5 * np.abs(sure - still).max()
