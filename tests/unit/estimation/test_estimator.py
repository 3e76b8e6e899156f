"""The estimator on a simulated robot: late and disordered measurements, loads, labels, and what it is sure of."""

from dataclasses import replace

import numpy as np
import pytest

from tendond.model.estimation.kalman.estimator import Estimator
from tendond.model.estimation.kalman.memory import Reading
from tendond.model.estimation.kalman.sensors import Markers
from tendond.model.estimation.kalman.state import EstimatorState
from tendond.model.rods.general import GeneralRod, GeneralState
from tests.unit.estimation.robots import PERIOD, POSITION, ROBOT, SLACK, Array, estimator_of, pose_of, rod

LOAD = np.array([0.0, 0.4, 0.1])


def pull(tick: int) -> Array:
    return np.array([2.0 * np.sin(0.02 * tick) ** 2, 0.0, 0.5, 0.0])


def followed(
    estimator: Estimator, plant: GeneralRod, cycles: int, load_at: int = 10**9, noise: float = 0.0, delay: int = 0
) -> tuple[list[EstimatorState], list[GeneralState], list[GeneralState]]:
    """Follow a robot; return estimates, estimated states and true ones, cycle by cycle."""
    rng = np.random.default_rng(0)
    model = estimator.rod
    truth, state = plant.solve_static(SLACK), model.solve_static(SLACK)
    estimate = estimator.start(state)
    past, found, states = [truth], [estimate], [state]
    for tick in range(1, cycles + 1):
        truth = plant.step(past[-1], pull(tick), tip_force=LOAD if tick >= load_at else np.zeros(3))
        past.append(truth)
        after = estimator.step(estimate, state, pull(tick))
        estimate = estimator.advance(estimate, state, after)
        seen = past[max(0, tick - delay)]
        reading = pose_of(plant, seen, min(delay, tick) * PERIOD, rng.normal(0.0, noise, 3) if noise else None)
        estimate, state = estimator.correct(estimate, after, [reading])
        found.append(estimate)
        states.append(state)
    return found, states, past


def test_a_load_that_comes_is_found_at_once_and_a_robot_as_the_model_has_none() -> None:
    plant = rod()
    estimates, states, truth = followed(estimator_of(rod()), plant, 200, load_at=120, noise=POSITION)
    assert estimates[119].jumped == -1
    assert np.linalg.norm(estimates[119].force[:2]) < 0.02
    assert 120 <= estimates[-1].jumped <= 122
    assert np.linalg.norm(estimates[150].force - LOAD) < 0.1 * np.linalg.norm(LOAD)
    apart = plant.strain_rod.backbone(truth[-1].strain) - plant.strain_rod.backbone(states[-1].strain)
    assert np.abs(apart).max() < 5e-4
    assert estimates[-1].consistency < 2.0


def test_what_is_late_leads_to_the_same_estimate_once_it_is_there() -> None:
    """With three cycles of delay the estimate of three cycles ago is that of a filter without."""
    plant = rod()
    prompt, _, _ = followed(estimator_of(rod(), age_max=0.05), plant, 150)
    late, _, _ = followed(estimator_of(rod(), age_max=0.05), plant, 153, delay=3)
    old = late[-1].moments[-4]
    errors = estimator_of(rod()).errors
    assert late[-1].front == 150
    force = (
        late[-1].force
        + (old.after - old.moved)[errors.force]
        - (late[-1].moments[-1].after - late[-1].moments[-1].moved)[errors.force]
    )
    assert force == pytest.approx(prompt[-1].force, abs=2e-3)
    own = late[-1].moments[-4].factors.covariance
    assert own == pytest.approx(prompt[-1].moments[-1].factors.covariance, abs=1e-2 * np.abs(own).max())


def test_measurements_out_of_order_end_where_those_in_order_do() -> None:
    plant, model = rod(), rod()
    ends = []
    for swapped in (False, True):
        estimator = estimator_of(model, age_max=0.05)
        truth, state = plant.solve_static(SLACK), model.solve_static(SLACK)
        estimate, past = estimator.start(state), [truth]
        for tick in range(1, 41):
            truth = plant.step(truth, pull(tick))
            past.append(truth)
            after = estimator.step(estimate, state, pull(tick))
            estimate, state = estimator.advance(estimate, state, after), after
            if tick % 2 == 0:  # two poses at once: of this cycle and of the one before it
                two = [pose_of(plant, past[-2], PERIOD), pose_of(plant, past[-1])]
                for one in reversed(two) if swapped else two:
                    estimate, state = estimator.correct(estimate, state, [one])
        ends.append((estimate, state, estimator.factors(estimate).covariance))
    (in_order, first, sure), (disordered, second, other) = ends
    assert disordered.force == pytest.approx(in_order.force, abs=1e-6)
    assert second.position == pytest.approx(first.position, abs=1e-8)
    assert other == pytest.approx(sure, rel=1e-6, abs=1e-9 * np.abs(sure).max())


def test_a_swapped_label_and_a_lost_marker_change_nothing() -> None:
    plant, model = rod(), rod()
    places = np.array([0.2, 0.35, 0.5])
    estimator = estimator_of(model, Markers(places, np.zeros(3), np.full(9, POSITION)))
    truth, state = plant.solve_static(SLACK), model.solve_static(SLACK)
    estimate = estimator.start(state)
    for tick in range(1, 101):
        truth = plant.step(truth, pull(tick))
        after = estimator.step(estimate, state, pull(tick))
        estimate = estimator.advance(estimate, state, after)
        points = plant.backbone.frames(truth.strain, places)[0]
        if 40 <= tick < 60:
            points = points[[1, 0, 2]]
        if 60 <= tick < 80:
            points[1] = np.nan
        estimate, state = estimator.correct(estimate, after, [Reading(1, 0.0, points.reshape(-1))])
        assert np.linalg.norm(state.position - truth.position) < 1e-3, tick
        taken = [len(one.lack) for one in estimate.moments[-1].taken]
        assert taken == [3 if 40 <= tick < 60 else 6 if 60 <= tick < 80 else 9]
    assert estimate.jumped == -1


def test_without_measurements_it_coasts_with_the_model_and_is_less_sure() -> None:
    plant = rod()
    estimator = estimator_of(rod())
    estimates, states, _ = followed(estimator, plant, 60)
    estimate, state = estimates[-1], states[-1]
    sure = estimator.tip_covariance(estimate, estimator.factors(estimate))
    for tick in range(61, 81):
        after = estimator.step(estimate, state, pull(tick))
        estimate, state = estimator.advance(estimate, state, after), after
    assert len(estimate.moments) == 3
    later = estimator.tip_covariance(estimate, estimator.factors(estimate))
    assert np.linalg.eigvalsh(later - sure)[-1] > 0.0
    assert np.trace(later) > 2.0 * np.trace(sure)


def test_a_stiffness_that_is_wrong_is_found_at_rest() -> None:
    plant = GeneralRod(replace(ROBOT), PERIOD, compliance=1.0 / 0.92)
    estimates, _, _ = followed(estimator_of(rod(), load_start=1e-3), plant, 150, noise=POSITION)
    assert estimates[-1].stiffness_error == pytest.approx(-0.08, abs=0.02)


def test_a_reading_that_leads_nowhere_is_left_out_and_a_place_without_orientation_is_not() -> None:
    plant = rod()
    estimator = estimator_of(rod())
    estimates, states, truth = followed(estimator, plant, 30)
    estimate, state = estimates[-1], states[-1]
    with np.errstate(all="ignore"):
        after, same = estimator.correct(estimate, state, [Reading(0, 0.0, np.full(3, 1e300), np.eye(3))])
    assert after is estimate
    assert same is state
    after, moved = estimator.correct(estimate, state, [Reading(0, 0.0, truth[-1].position + 1e-3)])
    assert [len(one.lack) for one in after.moments[-1].taken][-1] == 3
    assert np.linalg.norm(moved.position - truth[-1].position) > np.linalg.norm(state.position - truth[-1].position)
