"""The model along the horizon beside the model itself, and its derivatives beside differences."""

from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.predictive.horizon import Horizon
from tendond.daemon.control.predictive.rollout import Predictor, Rollout
from tendond.model.estimation.observer import ObserverState
from tendond.model.rods.general import GeneralRod, GeneralState
from tendond.model.rods.selection import model_rod
from tendond.schemas.config.rig import parse_config

ROBOTS = {
    "one section": '[control]\nsolver = "general"\n',
    "two sections": '[rod]\npreset = "rao-2021"\n',
}


def observer(force: Any = (0.0, 0.0, 0.0), pull: Any = (0.0, 0.0, 0.0)) -> ObserverState:
    zero = np.zeros(3)
    return ObserverState(np.zeros((2, 3)), zero, zero, zero, np.array(force), np.array(pull))


def bent(robot: str) -> tuple[GeneralRod, GeneralState, Any]:
    rod = model_rod(parse_config(ROBOTS[robot], "test"))
    assert isinstance(rod, GeneralRod)
    tensions = np.linspace(1.0, 3.0, rod.parameters.tendon_count)
    return rod, rod.solve_static(tensions), tensions


@pytest.mark.parametrize("robot", ROBOTS)
def test_the_first_step_is_the_models_own(robot: str) -> None:
    rod, state, tensions = bent(robot)
    found = Predictor(rod, Horizon.of(0.1, 4, 4, 0.01)).roll(
        state, observer((0.1, 0.0, 0.0), (0.0, 0.05, 0.0)), np.tile(1.5 * tensions, (4, 1))
    )
    step = rod.step(state, 1.5 * tensions, tip_force=np.array([0.1, 0.05, 0.0]))
    assert found.position[0] == pytest.approx(step.position, abs=1e-8)
    assert found.displacement[0] == pytest.approx(rod.displacements(step), abs=1e-8)


def numbers(found: Rollout) -> np.ndarray:
    outputs = (
        found.position,
        found.direction,
        found.side,
        found.displacement,
        found.strain,
        found.points.reshape(4, -1),
    )
    return np.concatenate(outputs, axis=1)


@pytest.mark.parametrize("robot", ROBOTS)
def test_derivatives_are_those_of_differences(robot: str) -> None:
    rod, state, tensions = bent(robot)
    at = rod.robot.length * np.array([0.3, 0.71, 1.0])
    predictor = Predictor(rod, Horizon.of(0.08, 4, 3, 0.01), at)
    plan = np.tile(1.3 * tensions, (3, 1)) + np.arange(3.0)[:, None]
    found = predictor.roll(state, observer(), plan)
    columns = plan.size
    exact = np.concatenate(
        (
            found.by_plan, found.direction_by_plan, found.side_by_plan,
            found.displacement_by_plan, found.strain_by_plan,
            found.points_by_plan.reshape(4, -1, columns),
        ),
        axis=1,
    )  # fmt: skip
    assert found.points[:, -1] == pytest.approx(found.position, abs=1e-12)
    for column in range(0, columns, 4):
        change = np.zeros(columns)
        change[column] = 3e-4
        ahead = numbers(predictor.roll(state, observer(), plan + change.reshape(plan.shape)))
        behind = numbers(predictor.roll(state, observer(), plan - change.reshape(plan.shape)))
        scale = np.abs(exact[:, :, column]).max()
        assert exact[:, :, column] == pytest.approx((ahead - behind) / 6e-4, abs=1e-3 * scale)
