"""The XL430's ratings in its manual bound a configuration with servos: 1.4 N m and 57 rpm at 11.1 V."""

import math
from pathlib import Path

import pytest

from tendond.cli.manual.config_text import config_toml
from tendond.drivers.dynamixel.serial.adapter import latency_warning
from tendond.drivers.dynamixel.strength import arrival_distance, range_margin, sag
from tendond.schemas.config.rig import ConfigError, parse_config
from tendond.schemas.config.servo import ServoSection

FITS = "displacement_min = -0.08\ndisplacement_max = 0.08\n"


def text(limits: str, servo: str = "") -> str:
    return f"[servo]\n{servo}[limits]\n{FITS}{limits}"


@pytest.mark.parametrize(
    ("limits", "servo", "objection"),
    [
        ("tension_max = 66.0\ndisplacement_rate = 0.08\n", "", r"tension_max = 66 N is more .* make 65\.3 N"),
        ("displacement_rate = 0.086\n", "", r"displacement_rate = 0.086 m/s is faster than the servos: 0.085 m/s"),
        # 57 rpm on 15 mm are 89.5 mm/s, whatever else is set
        (
            "displacement_rate = 0.0896\n",
            "displacement_rate = 0.5\nprofile_velocity = 6.35\n",
            r"faster than the servos: 0\.08954 m/s by .*57 rpm",
        ),
        ("tension_max = 49.1\ndisplacement_rate = 0.08\n", "spool_radius = 0.02\n", r"make 49\.0 N"),
        ("displacement_rate = 0.08\n", "displacement_max = 0.05\n", r"displacement_max = 0.08 m is outside"),
        ("displacement_rate = 0.08\n", "ids = [1, 2, 3]\n", "servo.ids has 3 servos"),
        ("", "profile_velocity = 6.4\n", r"above the servos' Velocity Limit .*: 6\.355 rad/s"),
        # a turn of 50.3 mm: 20 mm and 70.3 mm would look alike after a reboot
        ("", "spool_radius = 0.008\n", r"more than a turn of the spool, 0\.05027 m at spool_radius = 0\.008 m"),
        ("", "displacement_min = -0.09\n", r"displacement_min = -0\.09 m and home_window = 0\.01 m together are more"),
    ],
)
def test_what_the_servos_cannot_do_is_refused_with_the_figure(limits: str, servo: str, objection: str) -> None:
    with pytest.raises(ConfigError, match=objection):
        parse_config(text(limits, servo), "rig.toml")


def test_what_the_servos_can_do_is_taken_and_without_servos_nothing_is_asked() -> None:
    parse_config(text("tension_max = 65.0\ndisplacement_rate = 0.085\n"), "rig.toml")
    parse_config(text("tension_max = 48.9\ndisplacement_rate = 0.08\n", "spool_radius = 0.02\n"), "rig.toml")
    parse_config("[limits]\ntension_max = 400.0\ndisplacement_rate = 5.0\n", "rig.toml")


def test_limits_that_are_not_set_follow_from_the_servos_and_show_as_values() -> None:
    empty = parse_config("[servo]\n[vicon]\n", "rig.toml")
    limits = empty.limits
    assert (limits.displacement_min, limits.displacement_max, limits.displacement_rate) == (-0.08, 0.08, 0.085)
    assert limits.tension_max == 60.0
    assert parse_config(config_toml(empty), "shown").limits == limits
    small = parse_config(
        "[servo]\ndisplacement_max = 0.05\ndisplacement_rate = 0.04\nspool_radius = 0.02\n", "rig.toml"
    )
    assert (small.limits.displacement_max, small.limits.displacement_rate) == (0.05, 0.04)
    assert small.limits.tension_max == pytest.approx(1.4 * 0.7 / 0.02)


def test_servos_with_more_travel_than_the_defaults_do_not_widen_them() -> None:
    wide = parse_config("[servo]\nspool_radius = 0.03\ndisplacement_min = -0.15\ndisplacement_max = 0.15\n", "rig.toml")
    assert (wide.limits.displacement_min, wide.limits.displacement_max) == (-0.12, 0.12)


@pytest.mark.parametrize("key", ["displacement_min = -0.12", "displacement_max = 0.12", "displacement_rate = 0.09"])
def test_limits_that_are_set_are_refused_rather_than_changed(key: str) -> None:
    with pytest.raises(ConfigError, match="limits." + key.split(" ", maxsplit=1)[0]):
        parse_config(f"[servo]\n[limits]\n{key}\n", "rig.toml")


def test_the_example_with_a_servo_section_is_valid() -> None:
    example = (Path(__file__).parents[3] / "deploy" / "rig.toml").read_text()
    for section in ("servo", "vicon"):
        assert f"#[{section}]" in example
        example = example.replace(f"#[{section}]", f"[{section}]")
    assert parse_config(example, "rig.toml").limits.displacement_max == 0.08


def test_an_adapter_that_delays_replies_is_named_with_the_remedy(tmp_path: Path) -> None:
    timer = tmp_path / "bus" / "usb-serial" / "devices" / "ttyUSB0" / "latency_timer"
    timer.parent.mkdir(parents=True)
    link = tmp_path / "servos"
    link.symlink_to("/dev/ttyUSB0")
    timer.write_text("16\n")
    for port in ("/dev/ttyUSB0", str(link)):
        assert latency_warning(port, tmp_path) == (
            f"{port}: its latency timer is 16 ms, replies come late: echo 1 > {timer}"
        )
    timer.write_text("1\n")
    assert latency_warning("/dev/ttyUSB0", tmp_path) == ""
    assert latency_warning("/dev/ttyACM0", tmp_path) == ""


def test_a_servo_stays_behind_its_goal_in_proportion_to_its_load() -> None:
    """Position P Gain 640 in units of 1/128: 5 of 885 units of output a tick, 177 ticks at the stall torque."""
    whole = 177.0 / 4096.0 * 2.0 * math.pi * 0.015
    assert sag(1.0, 0.015) == pytest.approx(whole)
    assert range_margin(0.015) == pytest.approx(0.5 * whole)
    assert range_margin(0.03) == pytest.approx(whole)
    assert arrival_distance(ServoSection(pretension_load=0.06), 0.015) == pytest.approx(0.22 * whole)
    assert arrival_distance(ServoSection(), 0.015) < 0.5 * range_margin(0.015)
