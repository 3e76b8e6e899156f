"""Identification on the general rod: an arm of two sections by its logs, and a rod that both solvers describe."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from tendond.cli.app import app
from tendond.cli.common import load_config
from tendond.model.strain.describe.configured import robot_from_section
from tendond.offline.identification.configured import ABSENT, nominal, with_values
from tendond.offline.identification.excitation.dry_run import dry_run
from tendond.offline.identification.excitation.plan import propose
from tendond.offline.identification.recordings.checks import check, errors
from tendond.offline.identification.recordings.load import load_recording
from tendond.offline.identification.simulation.simulate import Simulation
from tendond.schemas.config.rig import check_config
from tests.unit.cli.commands import tendond
from tests.unit.identification.recordings import TRUE, recording

ARM = """
[rod]
gravity = [-9.81, 0.0, 0.0]
damping_ratio = 0.15
[[rod.section]]
length = 0.2
radius = 1e-3
youngs_modulus = 190e9
density = 12000.0
disk_number = 4
disk_mass = 2e-3
[[rod.section]]
length = 0.25
radius = 8e-4
youngs_modulus = 190e9
density = 12000.0
[[rod.tendon]]
position = [0.015, 0.0]
stiffness = 2e4
[[rod.tendon]]
position = [-0.015, 0.0]
stiffness = 2e4
[[rod.tendon]]
position = [0.0, 0.012]
end = 0.2
stiffness = 2e4
[[rod.tendon]]
position = [0.0, -0.012]
end = 0.2
stiffness = 2e4
"""
TABLES = {
    "limits": {
        "tension_max": 40.0, "displacement_min": -0.06, "displacement_max": 0.06, "displacement_rate": 0.085,
        "slack": 0.001,
    },
    "control": {"law": "sensitivity"}, "reference": {"across": 0.1}, "observer": {"delay": 0.005},
}  # fmt: skip
PERIOD = 0.002
TRUTH = {"E": 0.9, "Bbt": 1.3, "tendon_stiffness": 0.8, "delay": 0.01, "lag": 0.02}
"""Values of the plant; those of the controller's model are 1, 5 ms and no lag."""

PLANT = {
    "period": PERIOD,
    "drive": "displacement",
    "rod": {"scale": {"stiffness": 0.9, "damping": 1.3, "tendon_stiffness": 0.8}},
    "servo": {"lag": 0.02},
    "mocap": {"noise": 1e-4, "latency": 0.01, "period": 0.01},
}


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The arm's configuration, beside a log of it by the real controller on an arm of other parameters."""
    folder = tmp_path_factory.mktemp("arm")
    (folder / "arm.toml").write_text(ARM)
    rod = load_config(folder / "arm.toml").rod.model_dump(exclude_none=True)
    config = check_config({**TABLES, "rod": rod, "simulator": PLANT}, "arm")
    plan = propose(config, ("sway",), 0.7)
    dry_run(config, replace(plan, requests=plan.requests[:3], duration=plan.parts[1][0]), folder / "arm.mcap")
    return folder


def test_an_arm_of_two_sections_is_identified_by_factors_that_its_configuration_includes(arm: Path) -> None:
    names = "E,Bbt,C,tendon_stiffness,delay,lag"
    arguments = ["identify", str(arm / "arm.mcap"), "--out", str(arm), "--parameters", names, "--jobs", "2"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    found = json.loads((arm / "identified.json").read_text())["parameters"]
    for name, true in TRUTH.items():
        off = abs(found[name]["value"] - true)
        assert off < 4.0 * found[name]["standard_error"] + 1e-3 * true, name
        assert off < 0.03 * true + 2e-4, name
    assert (found["C"]["found"], found["C"]["why"]) == (False, ABSENT)
    (file,) = arm.glob("identified-*.toml")
    (arm / "both.toml").write_text(f'include = ["{file.name}"]\n{ARM}')
    believed, before = (robot_from_section(load_config(arm / name).rod) for name in ("both.toml", "arm.toml"))
    for one, other in zip(believed.sections, before.sections, strict=True):
        assert one.bending_stiffness[0] / other.bending_stiffness[0] == pytest.approx(found["E"]["value"], rel=1e-4)
        assert one.bending_damping[2] / other.bending_damping[2] == pytest.approx(found["Bbt"]["value"], rel=1e-4)
        assert one.mass_per_length == other.mass_per_length


def test_a_log_of_the_simulators_ideal_drive_is_refused(arm: Path, tmp_path: Path) -> None:
    config = check_config({"limits": {"slack": 0.001}}, "ideal")
    plan = propose(config, ("sway",), 0.5)
    dry_run(config, replace(plan, requests=plan.requests[:3], duration=plan.parts[1][0]), tmp_path / "ideal.mcap")
    (finding,) = errors(check([load_recording(tmp_path / "ideal.mcap", {})], "measured"))
    assert finding.name == "ideal drive"
    assert 'simulator.drive = "displacement"' in finding.text
    assert not errors(check([load_recording(arm / "arm.mcap", {})], "measured"))


def test_logs_of_different_sections_are_not_fitted_together(arm: Path) -> None:
    one = load_recording(arm / "arm.mcap", {})
    sections = tuple(section.model_copy(update={"disk_number": 5}) for section in one.config.rod.section)
    rod = one.config.rod.model_copy(update={"section": sections})
    other = replace(one, config=one.config.model_copy(update={"rod": rod}))
    assert ["rod.section is not that of" in finding.text for finding in errors(check([one, other], "measured"))] == [
        True
    ]


def test_both_rods_move_alike_through_a_recording() -> None:
    """Half a step off, as what they hold over a step differs, they would be 12 mm apart."""
    made = recording(noise=0.0)
    general = made.config.model_copy(update={"control": made.config.control.model_copy(update={"solver": "general"})})
    shooting, strain = Simulation(made, "command"), Simulation(replace(made, config=general), "command")
    assert (shooting.general, strain.general) == (False, True)
    ours = strain.motions([TRUE, {**TRUE, "E": 1.1 * TRUE["E"], "tip_mass": 0.01}])
    tips = [one.predicted_poses(one.motion(TRUE), TRUE["delay"]) for one in (shooting, strain)]
    assert np.array_equal(tips[1], strain.predicted_poses(ours[0], TRUE["delay"]))
    assert np.linalg.norm(tips[1] - tips[0], axis=1).max() < 1e-3


def test_factors_multiply_what_their_names_say() -> None:
    scale = {"stiffness": 1.2, "mass": 1.3, "damping": 1.4, "drag": 1.5, "tendon_stiffness": 1.6}
    section = {"length": 0.3, "radius": [[0.0, 1e-3], [0.3, 8e-4]], "youngs_modulus": 60e9, "density": 6500.0,
               "bending_damping": [1e-3, 1e-3, 8e-4], "drag": [0.1, 0.1, 0.0], "disk_number": 2, "disk_mass": 1e-3,
               "disk_inertia": [1e-7, 1e-7, 2e-7]}  # fmt: skip
    rod = {"section": [section], "tip": {"mass": 0.01}, "tendon": [{"position": [0.01, 0.0], "stiffness": 2e4}]}
    plain, other = (
        robot_from_section(check_config({"rod": {**rod, **more}}, "test").rod) for more in ({}, {"scale": scale})
    )
    factors = {"bending_stiffness": 1.2, "torsion_stiffness": 1.2, "axial_stiffness": 1.2, "mass_per_length": 1.3}
    factors |= {"polar_inertia": 1.3, "bending_damping": 1.4, "drag": 1.5}
    for s in (0.0, 0.1, 0.3):
        for name, factor in factors.items():
            one, two = (robot.sections[0].at(name, s) for robot in (plain, other))
            assert np.allclose(two, factor * one, rtol=1e-12), name
    assert [body.mass for body in other.bodies] == pytest.approx([1.3e-3, 1.3e-3, 0.01])
    assert other.bodies[0].inertia[2] == pytest.approx(2.6e-7)
    assert other.tendons[0].stiffness == pytest.approx(3.2e4)


def test_factors_on_one_uniform_section_become_its_own_values() -> None:
    rod = check_config({"rod": {"scale": {"stiffness": 1.1, "mass": 0.9, "damping": 2.0}}}, "test").rod
    assert rod.scale is None
    plain = check_config({}, "test").rod
    assert rod.youngs_modulus == pytest.approx(1.1 * plain.youngs_modulus)
    assert rod.density == pytest.approx(0.9 * plain.density)
    assert rod.bending_damping == pytest.approx([2.0 * one for one in plain.bending_damping])
    assert type(rod).model_validate_json(rod.model_dump_json()) == rod


def test_values_of_an_arm_come_back_from_its_configuration(arm: Path) -> None:
    config = load_config(arm / "arm.toml")
    believed = with_values(config, {"E": 1.05, "Bbt": 0.8, "C": 2.0, "tip_mass": 0.02})
    assert nominal(config) | {"E": 1.05, "Bbt": 0.8, "tip_mass": 0.02} == nominal(believed)


def test_an_error_of_a_log_is_said_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    config = check_config({"limits": {"slack": 0.001}}, "ideal")
    plan = propose(config, ("sway",), 0.5)
    dry_run(config, replace(plan, requests=plan.requests[:3], duration=plan.parts[1][0]), tmp_path / "ideal.mcap")
    ended = tendond(capsys, "identify", str(tmp_path / "ideal.mcap"), "--out", str(tmp_path / "out"))
    assert ended.status == 1
    (line,) = [line for line in ended.said.splitlines() if "ideal drive" in line]
    assert line.startswith(f"tendond: {tmp_path / 'ideal.mcap'}: ideal drive: ")
