"""[[sensors]]: what is allowed, and what is said of the rest."""

import pytest

from tendond.cli.manual.config_text import config_toml
from tendond.schemas.config.rig import ConfigError, RigConfig, parse_config

GOOD = """\
[[sensors]]
name = "skin"
kind = "markers"
at = [0.1, 0.2, 0.4]
offset = [0.0, 0.02, 0.0]
noise = 2e-4
delay = 0.01

[[sensors]]
name = "gratings"
kind = "curvature"
at = [0.05, 0.35]
noise = 0.05
rate = 50.0

[[sensors]]
name = "cells"
kind = "tension"
tendons = [2, 0]
noise = 0.2
required = true

[[sensors]]
name = "imu"
kind = "imu"
noise = [0.01, 0.1]

[[sensors]]
name = "vehicle"
kind = "base"
noise = [1e-3, 1e-2]
timeout = 1.0
"""


def test_every_kind_says_how_many_rows_of_how_many_numbers_a_reading_has() -> None:
    config = parse_config(GOOD, "t")
    shapes = {one.name: (one.rows, one.width) for one in config.sensors}
    assert shapes == {"skin": (3, 3), "gratings": (2, 2), "cells": (2, 1), "imu": (1, 6), "vehicle": (1, 7)}
    skin, _, _, imu, vehicle = config.sensors
    assert skin.offsets == ((0.0, 0.02, 0.0),) * 3
    assert imu.deviations == (0.01, 0.01, 0.01, 0.1, 0.1, 0.1)
    assert len(vehicle.deviations) == 6


def test_offsets_may_differ_from_place_to_place() -> None:
    config = parse_config(GOOD.replace("[0.0, 0.02, 0.0]", "[[0.0, 0.02, 0.0], [0.02, 0, 0], [0, -0.02, 0]]"), "t")
    assert config.sensors[0].offsets == ((0.0, 0.02, 0.0), (0.02, 0.0, 0.0), (0.0, -0.02, 0.0))


def test_a_configuration_with_sensors_is_written_as_it_was_read() -> None:
    config = parse_config(GOOD, "t")
    for changed in (False, True):
        assert parse_config(config_toml(config, changed=changed), "again") == config
    assert RigConfig.model_validate_json(config.model_dump_json()) == config


def test_without_sensors_a_configuration_is_written_as_before() -> None:
    assert "sensors" not in RigConfig().model_dump_json()
    assert "sensors" not in config_toml(RigConfig())


@pytest.mark.parametrize("text", ['[sensors]\nname = "skin"\n', "sensors = 3\n"])
def test_one_table_instead_of_a_list_is_told_the_heading(text: str) -> None:
    with pytest.raises(ConfigError, match=r"must be tables, each \[\[sensors\]\]$"):
        parse_config(text, "t")


WRONG = {
    'kind = "imu"': ('kind = "gyro"', 't:25: sensors[3].kind = "gyro": must be one of "markers", "curvature"'),
    "rate = 50.0": ("rte = 50.0", "t:14: sensors[1].rte: unknown key; did you mean 'rate'?"),
    'name = "cells"': ('name = "skin"', "t:17: sensors[2].name: 'skin' is the name of another sensor"),
    'name = "imu"': ('name = "my imu"', "t:24: sensors[3].name = \"my imu\": must be 1 to 32 of a-z, 0-9, '-' and '_'"),
    "at = [0.05, 0.35]": ("", "sensors[1].at: is missing: arc lengths of the curvature [m]"),
    "at = [0.1, 0.2, 0.4]": ("at = [0.1, 0.2, 9.0]", "t:4: sensors[0].at: 9 m lies beyond the backbone of "),
    "tendons = [2, 0]": ("tendons = [2, 4]", "sensors[2].tendons: 4, but the rod has tendons 0 to 3"),
    "required = true": ("at = [0.1]", "sensors[2].at: a sensor of kind 'tension' has none: remove it"),
    "noise = [0.01, 0.1]": ("noise = 0.1", "sensors[3].noise: must be two numbers, [rad/s, m/s^2], for kind 'imu'"),
    "noise = 0.2": ("noise = 0.0", "t:20: sensors[2].noise[0] = 0.0: must be a number > 0"),
    "noise = 2e-4": ("noise = [1e-4, 1e-4]", "sensors[0].noise: must be one number for kind 'markers'"),
    "offset = [0.0, 0.02, 0.0]": (
        "offset = [[0.0, 0.02, 0.0], [0.0, 0.0, 0.02]]",
        "sensors[0].offset: has 2 rows, at has 3 places: give one for all, or one each",
    ),
    "timeout = 1.0": ("rate = 2.0", "sensors[4].timeout: must be above the 0.5 s between two readings at rate = 2 Hz"),
    "delay = 0.01": ("delay = -1", "t:7: sensors[0].delay = -1: must be a number >= 0 and <= 0.5 [s]"),
}


@pytest.mark.parametrize("right", WRONG)
def test_a_wrong_key_is_named_with_what_is_allowed(right: str) -> None:
    wrong, said = WRONG[right]
    assert GOOD.count(right) == 1
    with pytest.raises(ConfigError) as caught:
        parse_config(GOOD.replace(right, wrong), "t")
    assert said in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1
