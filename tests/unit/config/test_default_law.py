"""The law of a configuration that names none follows from the robot; what is named is honoured."""

from typing import Any

import pytest

from tendond.drivers.simulator.lockstep import watched_loop
from tendond.offline.config_check import remarks
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.config.rod.presets import PRESETS
from tendond.schemas.config.rod.swing import swings
from tendond.schemas.requests import ControlAction


def of(rod: dict[str, Any], **tables: Any) -> RigConfig:
    return check_config({"rod": rod, **tables}, "test")


@pytest.mark.parametrize("robot", PRESETS)
def test_only_the_papers_robot_has_the_papers_law(robot: str) -> None:
    config = of({"preset": robot})
    assert config.control.law == ("backstepping" if robot == "paper" else "sensitivity")
    assert config.control.solver == (None if robot == "paper" else "general")


def test_a_law_that_is_named_is_kept_and_a_recorded_configuration_says_its_law() -> None:
    named = of({"preset": "rao-2021"}, control={"law": "backstepping"})
    assert named.control.law == "backstepping"
    assert check_config(named.model_dump(mode="json"), "test").control.law == "backstepping"
    chosen = of({"preset": "nitinol"})
    assert check_config(chosen.model_dump(mode="json"), "test") == chosen


def test_the_rules_of_old_logs_and_what_admits_no_rests_keep_the_papers_law() -> None:
    for control in ({"rules": 1}, {"feedback": "direct"}):
        assert of({"preset": "rao-2021"}, control=control).control.law == "backstepping"
    slow = {"damping_ratio": 0.04}
    assert of(slow, control={"solver": "shooting"}).control.law == "backstepping"
    assert of(slow).control.law == "sensitivity"


def test_light_damping_or_a_heavy_tip_on_a_robot_damped_less_than_the_papers_swings() -> None:
    def why(**rod: Any) -> str:
        return swings(of(rod).rod, 0.01)

    slender: dict[str, Any] = {
        "length": 0.25,
        "radius": 6e-4,
        "youngs_modulus": 60e9,
        "density": 6450.0,
        "tendon_positions": [[8e-3, 0]],
    }
    assert why() == why(tip_mass=0.1) == why(damping_ratio=0.06) == why(**slender, damping_ratio=0.3) == ""
    assert "damping ratio of 4 %, below 5 %" in why(damping_ratio=0.04)
    assert "its tip carries 4 g, and the paper's laws bear 0.9" in why(**slender, damping_ratio=0.3, tip_mass=4e-3)
    assert swings(of({**slender, "damping_ratio": 0.3, "tip_mass": 4e-3}).rod, 0.004) == ""
    assert swings(of({"tip_mass": 0.05}).rod, 0.02) == ""
    assert why(preset="rao-2021") == "it has 2 sections"
    tendons = [{"position": [0.02, 0.0], "end": 0.3}, {"position": [-0.02, 0.0]}]
    assert why(tendon=tendons) == "a tendon ends before its tip"
    assert why(tendon=[{"position": [0.02, 0.0], "friction": 0.1}, {"position": [-0.02, 0.0]}]) == ""
    assert why(precurvature=[0.0, 0.5, 0.0]) == ""


FAST: dict[str, Any] = {
    "length": 0.2, "radius": 7e-4, "youngs_modulus": 54e9, "density": 13966.0, "drag": [0.0, 0.0, 0.0],
    "tendon_positions": [[0.01, 0.0], [0.0, 0.01], [-0.01, 0.0], [0.0, -0.01]],
}  # fmt: skip
TASK: dict[str, Any] = {
    "reference": {"across": 0.07, "kind": "minimum_jerk", "duration": 2.0},
    "limits": {"tension_max": 9.9}, "pretension": {"tension": 0.4, "tension_min": 0.4},
}  # fmt: skip


def test_a_fast_arm_needs_more_damping_for_the_papers_law() -> None:
    assert of({**FAST, "damping_ratio": 0.05}, **TASK).control.law == "sensitivity"
    assert of({**FAST, "damping_ratio": 0.08}, **TASK).control.law == "backstepping"
    assert "5 %, below 7 %" in swings(of({**FAST, "damping_ratio": 0.05}).rod, 0.01)
    for ratio, law, mode in ((0.05, "backstepping", "fault"), (0.05, "sensitivity", "tracking"),
                             (0.08, "backstepping", "tracking")):  # fmt: skip
        config = of({**FAST, "damping_ratio": ratio}, control={"law": law}, **TASK)
        *_, last = watched_loop(config, 600, {5: ControlAction.ARM})
        assert (last.record.mode.value, law) == (mode, law)


def test_the_papers_law_on_a_robot_that_may_swing_is_remarked() -> None:
    said = "\n".join(
        remarks(of({"preset": "nitinol"}, control={"law": "backstepping"}, reference={"across": 0.1}), None)
    )
    assert "backstepping may swing this arm at 100 Hz: its first mode has a damping ratio of 2 %" in said
    for config in (of({"preset": "nitinol"}, reference={"across": 0.1}), RigConfig()):
        assert "may swing" not in "\n".join(remarks(config, None))
