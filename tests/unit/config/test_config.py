"""A configuration is refused before anything starts, and the message names file, key, value and what is allowed."""

import pytest

from tendond.schemas.config.rig import ConfigError, RigConfig, check_config, parse_config


def refused(text: str) -> str:
    with pytest.raises(ConfigError) as caught:
        parse_config(text, "rig.toml")
    return str(caught.value)


def test_an_empty_file_is_the_papers_robot() -> None:
    config = parse_config("", "rig.toml")
    assert config == RigConfig()
    assert (config.rod.length, config.rod.density, config.rod.space) == (0.5, 17189.0, "rk6")


def test_an_unknown_key_is_refused_with_the_nearest_one() -> None:
    assert refused("[rod]\nlenght = 0.4") == "rig.toml:2: rod.lenght: unknown key; did you mean 'length'?"


def test_an_unknown_section_is_refused_with_the_known_ones() -> None:
    message = refused("[qqq]\n")
    assert message.startswith("rig.toml:1: qqq: unknown key; known here: rig, bus, loop")


def test_a_value_out_of_range_names_key_value_and_range() -> None:
    message = refused("[rod]\nlength = -1")
    assert message == "rig.toml:2: rod.length = -1: must be a number > 0 and <= 10 [m]"


def test_not_a_number_is_refused() -> None:
    assert "rod.gravity[1] = NaN" in refused("[rod]\ngravity = [0, nan, 0]")
    assert "limits.tension_max" in refused("[limits]\ntension_max = inf")


def test_every_error_is_reported_at_once() -> None:
    lines = refused("[rod]\nlength = 0\nradius = 'x'\n[loop]\nperiode = 0.01").splitlines()
    assert len(lines) == 3
    assert all(line.startswith("rig.toml:") for line in lines)


def test_broken_toml_is_named_as_such() -> None:
    assert refused("[rod").startswith("rig.toml: is not valid TOML: ")


def test_tendons_that_do_not_exist_are_refused() -> None:
    assert "control.agonist = 4, but the rod has tendons 0 to 3" in refused("[control]\nagonist = 4")
    assert "same tendon" in refused("[control]\nantagonist = 0")


def test_controller_and_simulator_must_have_the_same_number_of_tendons() -> None:
    assert "tendon_positions" in refused("[simulator.rod]\ntendon_positions = [[0.02, 0.0]]")


@pytest.mark.parametrize("endpoint", ["127.0.0.1:7447", "tcp/127.0.0.1", "tcp/127.0.0.1:99999", "udp/1.2.3.4:1"])
def test_an_endpoint_must_have_its_form(endpoint: str) -> None:
    assert "bus.endpoint" in refused(f'[bus]\nendpoint = "{endpoint}"')


@pytest.mark.parametrize("name", ["", "a/b", "A", "a*", "x" * 33])
def test_a_rig_name_must_fit_a_key(name: str) -> None:
    assert "rig.name" in refused(f'[rig]\nname = "{name}"')


def test_a_name_may_be_as_long_as_its_source_can_carry() -> None:
    vicon = {"tip": "continuum_robot_tip_rigid_body"}
    with pytest.raises(ConfigError, match=r"vicon\.tip: .*24 bytes for a name, this has 30"):
        check_config({"vicon": vicon}, "test")
    found = check_config({"vicon": {"source": "datastream", **vicon}}, "test").vicon
    assert found is not None
    assert found.tip == vicon["tip"]


@pytest.mark.parametrize(
    "vicon",
    [
        {"address": "239.255.1.1"},
        {"address": "localhost"},
        {"address": ""},
        {"multicast": "192.168.1.1"},
        {"sender": "tracker.lab"},
        {"server": "192.168.1.1"},
    ],
)
def test_addresses_that_nothing_can_be_heard_on_are_refused(vicon: dict[str, str]) -> None:
    with pytest.raises(ConfigError, match=f"vicon.{next(iter(vicon))} = "):
        check_config({"vicon": vicon}, "test")
