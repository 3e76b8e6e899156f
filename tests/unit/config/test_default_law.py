"""The law of a configuration that names none follows from the robot; what is named is honoured."""

import pytest

from tendond.schemas.config.rig import check_config
from tendond.schemas.config.rod.presets import PRESETS


@pytest.mark.parametrize("robot", PRESETS)
def test_a_robot_whose_agonist_ends_before_the_tip_has_the_law_of_all_tendons(robot: str) -> None:
    law = check_config({"rod": {"preset": robot}}, "test").control.law
    assert law == ("sensitivity" if robot in ("rao-2021", "franka-tdcr-v4") else "backstepping")


def test_a_law_that_is_named_is_kept_and_a_recorded_configuration_says_its_law() -> None:
    named = check_config({"rod": {"preset": "rao-2021"}, "control": {"law": "backstepping"}}, "test")
    assert named.control.law == "backstepping"
    assert check_config(named.model_dump(mode="json"), "test").control.law == "backstepping"


def test_the_agonist_that_ends_at_the_tip_and_the_rules_of_old_logs_keep_the_papers_law() -> None:
    for control in ({"agonist": 3}, {"rules": 1}):
        assert check_config({"rod": {"preset": "rao-2021"}, "control": control}, "test").control.law == "backstepping"


def test_tendons_of_one_side_keep_the_papers_law() -> None:
    tendons = [{"position": (0.01, 0.0), "end": 0.2}, {"position": (0.01, 0.001), "end": 0.4}]
    sections = [{"length": 0.2, "radius": 7e-4, "youngs_modulus": 54e9, "mass_per_length": 0.01}] * 2
    assert check_config({"rod": {"section": sections, "tendon": tendons}}, "test").control.law == "backstepping"
