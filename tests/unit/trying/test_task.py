"""A trial: its first target, and what it changes of a rig's configuration."""

import numpy as np
import pytest

from tendond.daemon.control.reference.planar import PlanarReference
from tendond.daemon.control.reference.strain import yield_strain
from tendond.daemon.control.selection import Selection
from tendond.daemon.errors import TargetError, UsageError
from tendond.model.rods.selection import model_rod
from tendond.offline.equilibria_check import equilibria
from tendond.offline.trying.first_target import first_target, rounded_up
from tendond.offline.trying.task import trial
from tendond.schemas.config.presets import PROFILES
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.config.rod.presets import PRESETS

LAB = """\
[rig]
name = "lab"
[bus]
endpoint = "tcp/192.168.7.2:7460"
unguarded = true
[rod]
length = 0.3
radius = 0.0006
youngs_modulus = 200e9
density = 9000.0
damping_ratio = 0.03
tendon_positions = [[0.01, 0.0], [0.0, 0.01], [-0.01, 0.0], [0.0, -0.01]]
tendon_stiffness = 15000.0
[limits]
tension_max = 8.0
[observer]
delay = 0.01
command_delay = 0.018
[vicon]
[servo]
"""
"""A rig as a lab writes it, which says nothing of a simulator."""


def read(text: str) -> RigConfig:
    return parse_config(text, "rig.toml")


@pytest.mark.parametrize("preset", PRESETS)
def test_the_first_target_of_every_preset_is_reached_well_within_tension_strain_and_fold(preset: str) -> None:
    config = trial(read(f'[rod]\npreset = "{preset}"\n'), None).config
    reference = Selection.from_config(config, model_rod(config)).reference
    assert isinstance(reference, PlanarReference)
    assert reference.notes == ()
    target = next(one for one in equilibria(config) if one.target)
    limit, _ = yield_strain(config.rod)
    assert limit is not None
    assert target.number == 1
    assert target.tension < 0.55 * config.limits.tension_max
    assert target.strain < 0.55 * limit
    assert target.stability > 0.0
    rest = model_rod(config)
    start = rest.tip(rest.solve_static(np.zeros(len(config.rod.tendon_positions)))).position
    assert np.linalg.norm(np.array(reference.target) - start) > 0.2 * config.rod.backbone_length


def test_a_trial_has_neither_the_rigs_bus_nor_its_name_nor_its_drivers() -> None:
    made = trial(read(LAB), None)
    assert (made.config.vicon, made.config.servo) == (None, None)
    assert made.config.rig.name == "try"
    assert made.config.bus == RigConfig().bus
    assert made.config.limits == read(LAB).limits.model_copy(update={}), "its limits are those with the servos"
    assert "[vicon] and [servo]: not used" in made.remarks[0]


def test_a_simulator_that_the_file_does_not_describe_has_the_delays_that_the_controller_is_configured_for() -> None:
    simulator = trial(read(LAB), None).config.simulator
    assert simulator.mocap.latency == 0.01
    assert (simulator.drive, simulator.servo.lag) == ("displacement", 0.018)
    own = trial(read(LAB + "[simulator.mocap]\nnoise = 1e-4\n"), None).config.simulator
    assert (own.mocap.latency, own.mocap.noise, own.drive) == (0.0, 1e-4, "tension")


@pytest.mark.parametrize(
    "own", ["across = 0.1", "angle = 0.5", 'kind = "circle"\nradius = 0.05\n[control]\nlaw = "sensitivity"']
)
def test_a_task_of_the_file_is_kept(own: str) -> None:
    config = read(f"[reference]\n{own}\n")
    made = trial(config, None)
    assert made.config.reference == config.reference
    assert made.config.limits == config.limits


def test_limits_that_the_file_names_are_kept_and_soft_robots_get_a_soft_pretension() -> None:
    assert trial(read("[limits]\ntension_max = 50.0\n"), None).config.limits.tension_max == 50.0
    soft = read("[rod]\nradius = 2e-4\ndamping_ratio = 0.1\ndensity = 8000.0\n")
    made = trial(soft, None).config
    assert made.limits.tension_max < 1.0
    assert made.pretension.tension_min < 0.2 * made.limits.tension_max
    assert (
        trial(soft.model_copy(update={"pretension": PRETENSIONED.pretension}), None).config.pretension.tension == 0.01
    )


PRETENSIONED = read("[pretension]\ntension = 0.01\ntension_min = 0.02\n")


def test_a_target_that_is_given_replaces_the_files_and_selects_a_law_that_follows_it() -> None:
    config = read(PROFILES["paper"])
    assert trial(config, (0.1,)).config.reference.target_name == "across"
    assert trial(config, (0.1, 0.48)).config.reference.position == (0.1, 0.0, 0.48)
    made = trial(config, (0.1, 0.1, 0.45))
    assert (made.config.reference.kind, made.config.control.law) == ("point", "sensitivity")
    assert "control.law = 'sensitivity' for this trial" in made.remarks[-1]
    with pytest.raises(UsageError, match="in metres"):
        trial(config, (0.1, 0.1, 0.1, 0.1))


def test_an_agonist_that_does_not_bend_the_robot_in_the_plane_is_named() -> None:
    with pytest.raises(TargetError, match=r"control\.agonist = 0: that tendon hardly bends"):
        first_target(read("[rod]\ntendon_positions = [[1e-9, 0.02], [0.0, -0.02]]\ngravity = [0.0, 0.0, 0.0]\n"))


@pytest.mark.parametrize(("value", "up"), [(4.13, 4.2), (0.041, 0.041), (0.0411, 0.042), (29.5, 30.0), (100.0, 100.0)])
def test_a_limit_is_rounded_up(value: float, up: float) -> None:
    assert rounded_up(value) == up


def test_a_target_on_the_other_side_is_reached_by_the_tendon_there() -> None:
    made = trial(read(LAB), (-0.05,))
    assert (made.config.control.agonist, made.config.reference.across) == (2, -0.05)
    assert made.remarks[-1] == "control.agonist = 2 for this trial: tendon 0 bends the robot the other way"
    assert trial(read(LAB), (0.05,)).config.control.agonist == 0
    beyond = trial(read(LAB), (-0.4,))
    assert (beyond.config.control.agonist, len(beyond.remarks)) == (0, len(made.remarks) - 1)
