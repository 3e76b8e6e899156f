"""The poles of the loop with the filter on a bent arm: what makes them grow, and that the derived noise keeps them."""

from dataclasses import replace
from itertools import pairwise

import pytest

from tendond.daemon.control.estimation.estimator import configured_noise, estimator_with
from tendond.daemon.control.setup import CycleSetup
from tendond.model.estimation.kalman.estimator import QUIET, Estimator
from tendond.model.estimation.kalman.memory import Reading
from tendond.model.rods.general import GeneralRod
from tendond.offline.robustness.margins.filter_loop import gain_margin, radius
from tendond.offline.robustness.margins.filter_map import FilterCase, filter_config, filter_row
from tendond.offline.robustness.margins.filter_parts import model_parts, plant_parts, resting_tensions
from tendond.schemas.config.rig import RigConfig, check_config, parse_config
from tests.unit.estimation.robots import SLACK, estimator_of, pose_of, rod

BEND = 1.4


def _config() -> RigConfig:
    values = filter_config(parse_config("", "test")).model_dump()
    values["control"]["law"] = "sensitivity"
    values["reference"] = {"kind": "minimum_jerk", "angle": BEND}
    values["observer"]["delay"] = 0.01
    return check_config(values, "test")


def test_on_a_bent_arm_the_derived_noise_keeps_the_poles_that_a_trusted_camera_lets_grow() -> None:
    setup = CycleSetup.from_config(_config())
    rod_ = setup.rod
    assert isinstance(rod_, GeneralRod)
    tensions = resting_tensions(setup, BEND)
    heavy = plant_parts(rod_, 0.02, 0.85, tensions)
    derived = model_parts(setup, tensions)
    assert radius(derived, heavy, 1, 1) < 1.0
    assert gain_margin(derived, [(heavy, 1)], 1) >= 1.3
    trusting = estimator_with(setup.config, rod_, configured_noise(setup.config, rod_))
    sharp = model_parts(replace(setup, estimator=trusting), tensions)
    assert radius(sharp, heavy, 1, 1) > 1.0


@pytest.mark.parametrize("law", ["backstepping", "sliding_mode"])
def test_no_motion_of_a_bent_arm_grows_by_the_laws_of_the_paper(law: str) -> None:
    row = filter_row(filter_config(parse_config("", "test")), FilterCase(law, 100.0, 0.01, BEND))
    assert row.passes
    assert row.nominal < 1.0
    assert row.decay > 0.0


def _jumps(estimator: Estimator, model: GeneralRod, loads: list[float]) -> list[int]:
    """Return the ticks at which loads were taken to have come, with a force across on the plant's tip [N]."""
    truth = state = model.solve_static(SLACK)
    estimate, found = estimator.start(state), []
    for load in loads:
        truth = model.step(truth, SLACK, tip_force=(load, 0.0, 0.0))
        after = estimator.step(estimate, state, SLACK)
        estimate = estimator.advance(estimate, state, after)
        seen = pose_of(model, truth)
        estimate, state = estimator.correct(estimate, after, [Reading(0, 0.0, seen.value, seen.rotation)])
        if estimate.jumped >= 0 and estimate.jumped not in found:
            found.append(estimate.jumped)
    return found


def test_a_load_that_comes_again_and_again_is_no_jump_any_more() -> None:
    model = rod()
    estimator = estimator_of(model)
    swinging = [0.0] * 20 + [0.6 if index // 12 % 2 else -0.6 for index in range(240)]
    found = _jumps(estimator, model, swinging)
    apart = [after - before for before, after in pairwise(found)]
    assert len(found) >= 2
    assert all(gap > QUIET * 2**index for index, gap in enumerate(apart))


def test_a_second_load_after_a_while_is_seen_at_once() -> None:
    model = rod()
    found = _jumps(estimator_of(model), model, [0.0] * 20 + [0.6] * 130 + [-0.6] * 20)
    assert any(20 <= tick <= 26 for tick in found)
    assert any(150 <= tick <= 156 for tick in found)
