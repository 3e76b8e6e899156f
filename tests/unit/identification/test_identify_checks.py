"""Bad data, found and named before anything is fitted."""

from dataclasses import replace

import numpy as np
import pytest

from tendond.offline.identification.recordings.checks import check
from tendond.offline.identification.recordings.recording import Drive, Recording
from tests.unit.identification.recordings import CONFIG, TRUE, recording


@pytest.fixture(scope="module")
def good() -> Recording:
    return recording()


def named(*recordings: Recording, level: str = "error", drive: Drive = "measured") -> set[str]:
    """Names of what is found."""
    return {one.name for one in check(recordings, drive) if one.level == level}


def test_good_data_have_no_errors(good: Recording) -> None:
    assert named(good) == set()


def test_every_finding_is_one_line_that_names_the_log(good: Recording) -> None:
    for finding in check([replace(good, hidden=10 * good.cycles, fault="limits: at one"), good], "measured"):
        assert "\n" not in finding.text
        assert str(good.path) in finding.text


def test_no_motion(good: Recording) -> None:
    random = np.random.default_rng(0)
    still = good.position[:1] + 1e-4 * random.standard_normal(good.position.shape)
    assert named(replace(good, position=still)) == {"no motion"}


def test_occlusions(good: Recording) -> None:
    assert named(replace(good, hidden=int(0.6 * good.cycles))) == {"occlusions"}
    assert "occlusions" in named(replace(good, hidden=int(0.1 * good.cycles)), level="warning")


def test_one_tendon_only(good: Recording) -> None:
    assert "one tendon only" in named(good, level="warning")
    both = good.command.copy()
    both[80:110, 2] = 0.01
    assert "one tendon only" not in named(replace(good, command=both), level="warning")
    slack = np.full_like(good.command, -0.01)
    assert "no tendon pulled" in named(replace(good, command=slack, reported=slack))


def test_wrong_rig_by_name_and_by_geometry(good: Recording) -> None:
    other = good.config.model_copy(update={"rig": good.config.rig.model_copy(update={"name": "other"})})
    assert named(good, replace(good, config=other)) == {"wrong rig"}
    longer = good.config.model_copy(update={"rod": good.config.rod.model_copy(update={"radius": 1.1e-3})})
    assert named(good, replace(good, config=longer)) == {"wrong rig"}


def test_logs_of_two_tip_masses_are_reported(good: Recording) -> None:
    loaded = good.config.model_copy(update={"rod": good.config.rod.model_copy(update={"tip_mass": 0.02})})
    assert "tip mass" in named(good, replace(good, config=loaded), level="warning")
    assert "tip mass" not in named(good, good, level="warning")


def test_a_tool_that_is_not_configured_does_not_make_another_rig() -> None:
    assert named(recording({**TRUE, "tip_mass": 0.03})) == set()


def test_wrong_rig_by_where_the_arm_rests_and_where_it_goes(good: Recording) -> None:
    lifted = good.position + np.array([0.0, 0.0, 0.2])
    assert named(replace(good, position=lifted)) == {"wrong rig"}
    mirrored = good.position * np.array([1.0, 1.0, 1.0])
    mirrored[:, 0] = 2.0 * good.position[0, 0] - mirrored[:, 0]
    findings = check([replace(good, position=mirrored)], "measured")
    assert any("does not go where the model goes" in one.text for one in findings)


def test_saturated(good: Recording) -> None:
    narrow = good.config.limits.model_copy(update={"displacement_max": float(good.command.max())})
    stuck = good.command.copy()
    stuck[60:-70, 0] = stuck.max()
    held = replace(good, command=stuck, config=good.config.model_copy(update={"limits": narrow}))
    assert "saturated" in named(held)
    assert "saturated" in named(replace(good, limited=0.9), level="warning")


def test_a_servo_that_does_not_follow(good: Recording) -> None:
    lazy = good.reported.copy()
    lazy[:, 0] = np.minimum(lazy[:, 0], 0.005)
    findings = check([replace(good, reported=lazy)], "measured")
    assert any("servo of tendon 0" in one.text and one.name == "saturated" for one in findings)


def test_servos_that_report_nothing_and_logs_that_are_too_short() -> None:
    silent = recording(reports=False)
    assert named(silent) == {"no reports"}
    assert named(silent, drive="command") == set()
    assert "too short" in named(replace(silent, times=silent.times[:50]), drive="command")


def test_faults_and_missed_deadlines_are_reported(good: Recording) -> None:
    warned = named(replace(good, fault="pose stale", missed=good.cycles // 2), level="warning")
    assert {"fault", "missed deadlines"} <= warned


def test_parameters_that_are_no_start_are_said_so(good: Recording) -> None:
    soft = CONFIG.model_copy(update={"rod": CONFIG.rod.model_copy(update={"youngs_modulus": 1e7, "density": 1e6})})
    assert named(replace(good, config=soft)) & {"no solution", "wrong rig"}
