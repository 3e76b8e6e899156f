"""Studies of robots that are not one uniform section: their plants, loads of their size, and a run."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tendond.model.rod.parameters import RodParameters
from tendond.model.rods.selection import model_rod
from tendond.model.strain.describe.configured import robot_from_section
from tendond.offline.robustness.margins.bent_stiffness import stiffness_rows
from tendond.offline.robustness.plants import rig_of
from tendond.offline.robustness.points import Point, points_of
from tendond.offline.robustness.run import run
from tendond.offline.robustness.settings import Settings
from tendond.offline.robustness.unlike import load_factor, unlike
from tendond.offline.trials.paths import trials
from tendond.schemas.config.rig import RigConfig, check_config
from tests.unit.offline.test_robustness_run import here, no_progress

TABLES: dict[str, Any] = {
    "control": {"law": "sensitivity"},
    "reference": {"across": 0.12},
    "limits": {"tension_max": 6.0},
    "pretension": {"tension_min": 0.1},
}
ARM = check_config({"rod": {"preset": "rao-2021"}, **TABLES}, "arm")


def test_a_plants_factors_are_on_all_sections_and_on_top_of_those_that_the_robot_has() -> None:
    believed = check_config({"rod": {"preset": "rao-2021", "scale": {"stiffness": 1.1}}, **TABLES}, "arm")
    point = Point("axes", "sensitivity", "force", youngs_factor=0.9, bending_damping_factor=2.0, drive="displacement")
    plant = robot_from_section(rig_of(believed, point, 0).simulator.rod)
    model = robot_from_section(ARM.rod)
    for one, other in zip(plant.sections, model.sections, strict=True):
        assert np.allclose(one.bending_stiffness, 0.99 * np.array(other.bending_stiffness))
        assert np.allclose(one.bending_damping, 2.0 * np.array(other.bending_damping))
        assert one.mass_per_length == other.mass_per_length
    assert all(tendon.stiffness for tendon in plant.tendons)
    assert not any(tendon.stiffness for tendon in model.tendons)


def test_a_uniform_plants_factors_are_on_its_keys() -> None:
    rod = RigConfig().rod
    plant = unlike(rod, 0.9, 2.0, 3.0)
    assert (plant.youngs_modulus, plant.bending_damping[2]) == (0.9 * rod.youngs_modulus, 2.0 * rod.bending_damping[2])
    assert plant.drag[0] == 3.0 * rod.drag[0]


def test_loads_are_the_papers_on_its_robot_and_bend_another_one_as_far() -> None:
    assert load_factor(RodParameters()) == 1.0
    arm = model_rod(ARM).parameters
    factor = load_factor(arm)
    assert factor == pytest.approx(
        arm.bending_stiffness / arm.length**2 / (RodParameters().bending_stiffness / 0.25), rel=0.05
    )
    points = points_of("axes", ["sensitivity"], ["force"], load=factor)
    assert max(point.load_g for point in points) == pytest.approx(50.0 * factor)
    assert max(point.impact_n for point in points) == pytest.approx(10.0 * factor)


def test_an_arm_of_two_sections_meets_the_goal_on_the_robot_of_its_model(tmp_path: Path, monkeypatch: Any) -> None:
    settings = Settings("axes", 1, 0, ("sensitivity",), ("force",), ARM)
    nominal = Point("axes", "sensitivity", "force")
    monkeypatch.setattr("tendond.offline.robustness.run.points_of", lambda *given, **more: [nominal])
    ((point, result),) = run(settings, tmp_path, here, no_progress)
    assert point == nominal
    assert result.meets, result
    assert result.steady_error_mm is not None
    assert result.steady_error_mm < 0.01


def test_pushes_measure_the_stiffness_of_a_straight_arm_by_either_rod() -> None:
    """3 EI / L^3 of the cantilever, of the uniform rod that stands for the arm."""
    for config in (ARM, check_config({"rod": {"gravity": [0.0, 0.0, 0.0]}}, "paper")):
        row = next(stiffness_rows(config))
        assert row.arm == pytest.approx(1.0, abs=2e-3)


def test_trajectories_have_the_size_of_the_robot() -> None:
    papers, arms = trials(RigConfig()), trials(ARM)
    assert [trial.name for trial in papers] == [trial.name for trial in trials()]
    assert [trial.reference["radius"] for trial in arms if trial.name.startswith("circle 80 mm")] == pytest.approx(
        [0.08] * 4
    )
    assert not any(trial.rod for trial in arms)
    assert arms[0].goal_mm == pytest.approx(0.8 * papers[0].goal_mm)


def test_a_damping_ratio_beside_a_helical_tendon_is_read_again_from_what_is_written() -> None:
    rod = check_config(
        {"rod": {"damping_ratio": 0.02, "tendon": [{"position": [0.01, 0.0], "turns": 0.2}]}}, "helix"
    ).rod
    assert type(rod).model_validate_json(rod.model_dump_json()) == rod
    assert rod.damping_ratio == 0.02
