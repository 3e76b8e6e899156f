"""Fits to rests: logs of an arm that is pulled and waits, by the other rod in motion, and by one whose tendons rub."""

import tomllib
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from tendond.model.strain.describe.configured import robot_from_section
from tendond.offline.identification.configured import nominal, section_with
from tendond.offline.identification.geometry import base_shift, base_turn
from tendond.offline.identification.identify import identify
from tendond.offline.identification.options import Options
from tendond.offline.identification.recordings.recording import DataError, Recording
from tendond.offline.identification.recordings.rests import find_rests, has_only_rests
from tendond.offline.identification.results.parameter_file import parameter_file
from tendond.offline.identification.results.report import fitted_to
from tendond.offline.identification.results.result import Identification
from tendond.schemas.config.rig import check_config, parse_config
from tests.unit.identification.recordings import CONFIG, POSES, TRUE, pulls_and_waits, recording

WRONG = {"zero_1": 0.0015, "base_x": 0.004, "base_z": -0.003, "base_turn_y": 0.03, "base_turn_z": -0.05}
RUBBING = {**TRUE, **WRONG, "mu": 0.15}


@pytest.fixture(scope="module")
def waiting() -> Recording:
    """The shooting rod in motion, which waits 17 times."""
    return recording(moved=pulls_and_waits(POSES))


@pytest.fixture(scope="module")
def rubbing() -> Recording:
    """An arm whose tendons rub, whose base is turned and shifted, and one of whose tendons has a wrong zero."""
    return recording(RUBBING, moved=pulls_and_waits(POSES), general=True, step=0.0025)


@pytest.fixture(scope="module")
def found(rubbing: Recording) -> Identification:
    return identify([rubbing], [], Options(("E", "tendon_stiffness", "mu", "base", "zeros"), jobs=2))


def within(result: Identification, true: dict[str, float], errors: float) -> None:
    """Compare with the truth; forces with their ratio to the density, which these logs do not fix."""
    scale = nominal(CONFIG)["rho"] / true["rho"]
    for one in result.parameters:
        goal = true[one.parameter.name] * (scale if one.parameter.force else 1.0)
        assert one.found, one.why
        assert abs(one.value - goal) <= errors * one.error, one.parameter.name


def test_a_log_of_pulls_and_waits_is_fitted_at_its_rests(waiting: Recording) -> None:
    """The rig is the shooting rod, which is integrated from pull to pull; the fit is the general rod's equilibria."""
    result = identify([waiting], [], Options(("E", "tendon_stiffness")))
    assert result.statics
    assert fitted_to(result) == "18 rests, one after the other"
    within(result, TRUE, 2.0)
    assert result.rms == pytest.approx(result.noise, rel=0.3)


def test_friction_base_and_zeros_are_found_beside_the_stiffness(found: Identification) -> None:
    within(found, RUBBING, 3.0)
    values = found.values
    assert values["mu"] == pytest.approx(0.15, abs=0.01)
    assert values["base_turn_z"] == pytest.approx(-0.05, abs=2e-3)
    assert values["zero_1"] == pytest.approx(0.0015, abs=1e-4)


def test_the_parameter_file_has_the_keys_and_names_what_the_controller_cannot_take(found: Identification) -> None:
    text = parameter_file(found, datetime(2026, 1, 2, tzinfo=UTC))
    rod = tomllib.loads(text)["rod"]
    assert rod["tendon_friction"] == pytest.approx(found.values["mu"], rel=1e-4)
    assert "base" not in rod
    assert "# zero_1 = " in text
    assert "# the camera sees the base as an object: correct it in Tracker" in text
    mounted = {"position": [0.1, 0.0, 0.0], "orientation": [0.6, 0.0, 0.8, 0.0]}
    config = check_config({"rod": {"base": mounted}, "vicon": {"base": ""}}, "mounted")
    text = parameter_file(replace(found, config=config), datetime(2026, 1, 2, tzinfo=UTC))
    believed, was = parse_config(text, "file").rod.base, config.rod.base
    assert believed is not None
    assert was is not None
    shift, turn = base_shift(found.values), base_turn(found.values)
    assert np.subtract(believed.position, was.position) == pytest.approx(was.to_world(shift), abs=1e-6)
    axis = was.to_world(tuple(turn.apply([0.0, 0.0, 1.0])))
    assert believed.to_world((0.0, 0.0, 1.0)) == pytest.approx(axis, abs=1e-5)


def test_a_moving_log_is_fitted_in_motion_and_has_too_few_rests(free: Recording) -> None:
    assert not has_only_rests(free)
    short = replace(free, times=free.times[:60], armed=free.armed[:60], command=free.command[:60])
    with pytest.raises(DataError, match=r"has 1 rests of 0\.3 s, and a fit to rests takes 4 or more"):
        find_rests(short, "measured")


def test_what_rests_do_not_show_is_named(waiting: Recording) -> None:
    result = identify([waiting], [], Options(("E", "Bbt", "delay", "lag", "backlash")))
    why = {one.parameter.name: one.why for one in result.parameters if not one.found}
    assert set(why) == {"Bbt", "delay", "lag", "backlash"}
    assert "record motion" in why["Bbt"]
    assert "--drive command" in why["backlash"]


def test_a_backlash_is_found_from_commands_at_rest() -> None:
    """The servos report nothing; each turns round between some of the poses."""
    played = recording({**TRUE, "backlash": 4e-4}, moved=pulls_and_waits(POSES), reports=False)
    result = identify([played], [], Options(("E", "tendon_stiffness", "backlash")))
    assert result.drive == "command"
    assert result.values["backlash"] == pytest.approx(4e-4, abs=3e-5)


def test_routing_and_precurvature_are_found_and_written_as_keys() -> None:
    true = {**TRUE, "precurvature_x": 0.3, "precurvature_y": -0.2, "radius_2": 1.05}
    made = recording(true, moved=pulls_and_waits(POSES), general=True, step=0.0025)
    result = identify([made], [], Options(("E", "tendon_stiffness", "precurvature", "radii"), jobs=2))
    within(result, true, 3.0)
    rod = tomllib.loads(parameter_file(result, datetime(2026, 1, 2, tzinfo=UTC)))["rod"]
    assert rod["precurvature"] == pytest.approx([0.3, -0.2, 0.0], abs=5e-3)
    assert rod["tendon_positions"][2] == pytest.approx([-0.021, 0.0], abs=5e-5)


def test_an_arm_takes_corrections_of_all_its_tendons_and_sections() -> None:
    arm = check_config({"rod": {"preset": "rao-2021"}}, "arm").rod
    changed = section_with(arm, {"radius": 1.1, "radius_4": 1.2, "precurvature_x": 0.5, "mu": 0.1})
    plain, robot = robot_from_section(arm), robot_from_section(changed)
    for index, (one, other) in enumerate(zip(plain.tendons, robot.tendons, strict=True)):
        assert other.at(0.1) == pytest.approx(np.multiply(1.1 * (1.2 if index == 4 else 1.0), one.at(0.1)))
        assert (one.friction, other.friction) == (0.0, 0.1)
    assert [section.curvature for section in robot.sections] == [(0.5, 0.0, 0.0)] * 2
    assert nominal(check_config({"rod": changed.model_dump(exclude_none=True)}, "arm"))["radius_4"] == 1.32
