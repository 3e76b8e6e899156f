"""Messages for newcomers: another unit than the key's, defaults that nobody wrote, a robot without gravity."""

from pathlib import Path

import pytest

from tendond.cli.common import load_config
from tendond.daemon.control.reference.planar import plan_in_plane
from tendond.daemon.errors import TargetError
from tendond.model.rods.selection import model_rod
from tendond.offline.config_check import reference_remarks, remarks
from tendond.offline.robot_check import robot_report
from tendond.schemas.config.given import by_default
from tendond.schemas.config.rig import ConfigError, parse_config
from tendond.schemas.errors.units import unit_hint


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("[rod]\nlength = 300\n", "; if it is in mm, write 0.3"),
        ("[rod]\nyoungs_modulus = 200\n", "; if it is in GPa, write 2e+11"),
        ("[rod]\ntip_mass = 15\n", "; if it is in g, write 0.015"),
        ("[rod]\ndamping_ratio = 3\n", "; if it is in per cent, write 0.03"),
        ("[loop]\nperiod = 10\n", "; if it is in ms, write 0.01"),
        ("[reference]\nangle = 90\n", "; if it is in degrees, write 1.5708"),
        ('[reference]\nkind = "minimum_jrk"\n', "; did you mean 'minimum_jerk'?"),
        ('[rod]\npreset = "nitinoll"\n', "; did you mean 'nitinol'?"),
        ("[reference]\ntarget = 0.1\n", "unknown key; name it by position, across, angle or direction"),
        ("[rod]\nlength = 0,3\n", "; a decimal has a point: 0.3"),
        ("[[rod.section]]\nlength = 200\nradius = 1e-3\nyoungs_modulus = 2e11\ndensity = 8e3\n", "write 0.2"),
    ],
)
def test_a_value_that_would_be_right_in_another_unit_or_spelling_gets_a_hint(text: str, hint: str) -> None:
    with pytest.raises(ConfigError) as refused:
        parse_config(text, "rig.toml")
    assert str(refused.value).splitlines()[0].endswith(hint)


def test_what_no_unit_explains_gets_none() -> None:
    for text in ("[rod]\nlength = -1\n", '[rod]\nlength = "long"\n', "[rod]\nlength = 1e9\n"):
        with pytest.raises(ConfigError) as refused:
            parse_config(text, "rig.toml")
        assert "if it is in" not in str(refused.value)
    assert unit_hint(300, "N", lambda one: True) == ""


def refusal(text: str) -> str:
    config = parse_config(text, "rig.toml")
    with pytest.raises(TargetError) as refused:
        plan_in_plane(config, model_rod(config))
    return str(refused.value)


def test_a_target_in_millimetres_is_recognised_by_the_length_of_the_robot() -> None:
    assert refusal("[reference]\nacross = 80\n").endswith("; if it is in mm, write 0.08")
    assert "if it is in" not in refusal("[reference]\nacross = 0.45\n")


def test_a_default_target_and_limit_are_said_to_be_defaults() -> None:
    said = refusal("[rod]\nlength = 0.2\nradius = 5e-4\n")
    assert "up to limits.tension_max = 60 N (by default)" in said
    assert said.endswith("; no target is given: write reference.across")
    given = refusal("[rod]\nlength = 0.2\nradius = 5e-4\n[limits]\ntension_max = 60.0\n[reference]\nacross = 0.3\n")
    assert "by default" not in given
    assert "no target" not in given


def test_a_default_pretension_above_a_limit_that_was_given_is_the_key_to_write() -> None:
    with pytest.raises(ConfigError) as refused:
        parse_config("[limits]\ntension_max = 0.4\n", "rig.toml")
    first, second = str(refused.value).splitlines()
    assert "pretension.tension_min = 1 N (by default) must be below limits.tension_max = 0.4 N" in first
    assert second.endswith("they are 0.5 N (by default): write a lower pretension.tension")


def test_remarks_of_a_robot_name_defaults_as_such() -> None:
    thin = robot_report(parse_config("[rod]\nradius = 2e-4\nlength = 0.2\ndensity = 8e3\n", "rig.toml")).notes
    assert any("limits.tension_max = 60 N (by default) bends the robot" in one for one in thin)
    assert any(
        one.startswith("rod.bending_damping (by default, the paper's robot's): the first mode is overdamped")
        and one.endswith("write rod.damping_ratio")
        for one in thin
    )
    given = robot_report(parse_config("[rod]\nbending_damping = [0.2, 0.2, 0.2]\n", "rig.toml")).notes
    assert any(one.startswith("rod.bending_damping: ") and one.endswith("check its unit") for one in given)


def test_a_slow_camera_is_named_by_the_key_that_makes_it_slow() -> None:
    slow = list(remarks(parse_config("[simulator.mocap]\nperiod = 0.1\n[faults]\npose_timeout = 0.15\n", "x"), None))
    assert any("each 100 ms (simulator.mocap.period), and faults.pose_timeout = 150 ms covers" in one for one in slow)
    default = list(remarks(parse_config("[faults]\npose_timeout = 0.015\n", "x"), None))
    assert any("each 10 ms (simulator.period, by default)" in one for one in default)


@pytest.mark.parametrize(
    ("text", "source"),
    [('preset = "rao-2021"', ", by preset 'rao-2021')"), ("gravity = [0.0, 0.0, 0.0]", "(rod.gravity is zero)")],
)
def test_a_robot_without_gravity_is_said_to_be_one(text: str, source: str) -> None:
    lines = robot_report(parse_config(f"[rod]\n{text}\n", "rig.toml")).lines
    (said,) = (one for one in lines if "without gravity" in one)
    assert source in said
    assert not any("sags" in one for one in lines)


def test_a_file_of_samples_does_not_make_the_other_keys_given(tmp_path: Path) -> None:
    (tmp_path / "samples.csv").write_text("t,x,z\n0,-0.02,0.4992\n1,0.0,0.4999\n")
    (tmp_path / "rig.toml").write_text('[reference]\nkind = "samples"\nfile = "samples.csv"\n[limits]\nslack = 0.001\n')
    config = load_config(tmp_path / "rig.toml")
    assert len(config.reference.samples) == 2
    assert by_default(config.limits, "tension_max")
    assert not by_default(config.limits, "slack")


def test_the_check_says_what_the_controller_says_of_its_reference() -> None:
    (folded,) = reference_remarks(parse_config("[reference]\nacross = 0.3\n", "rig.toml"))
    assert "of 2 resting shapes the folded one, bent by" in folded
    assert "by the default of reference.branch; branch = 1 is bent by" in folded
    (strained,) = reference_remarks(parse_config("[rod]\nyield_strain = 0.004\n", "rig.toml"))
    assert strained.startswith("at the target the backbone is strained by 0.58 %, more than the 0.4 % that it bears")
