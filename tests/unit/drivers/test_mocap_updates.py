"""Repetitions of a client told from measurements, and the configuration of each system."""

import pytest

from tendond.drivers.mocap.updates import FROZEN, Updates
from tendond.schemas.config.rig import ConfigError, RigConfig, check_config

HOLD = 100
TIP = (1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0)
MOVED = (1.1, *TIP[1:])
BASE = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


def test_a_repeated_tip_gives_nothing_and_after_the_hold_is_occluded() -> None:
    updates = Updates("tip", {"base"}, HOLD)
    assert updates.take({"tip": TIP, "base": BASE}, 0) == ({"tip": TIP, "base": BASE}, {})
    assert updates.take({"tip": TIP, "base": BASE}, 50) is None
    assert updates.take({"tip": TIP, "base": BASE}, 101) == (
        {"tip": None, "base": None},
        {"tip": FROZEN, "base": FROZEN},
    )
    assert updates.take({"tip": MOVED}, 110) == ({"tip": MOVED, "base": None}, {"base": FROZEN})


def test_a_base_that_comes_apart_from_the_tip_goes_with_it_while_it_is_recent() -> None:
    """VRPN sends each body by itself."""
    updates = Updates("tip", {"base"}, HOLD)
    assert updates.take({"base": BASE}, 0) is None
    assert updates.take({"tip": TIP}, 60) == ({"tip": TIP, "base": BASE}, {})
    assert updates.take({"tip": MOVED}, 101) == ({"tip": MOVED, "base": None}, {"base": FROZEN})


def test_a_body_that_never_came_is_missing() -> None:
    updates = Updates("tip", {"base"}, HOLD)
    assert updates.take({}, 0) is None
    assert updates.take({}, 101) == ({}, {})
    assert updates.take({"tip": TIP}, 110) == ({"tip": TIP}, {})


def mocap(**keys: object) -> RigConfig:
    return check_config({"mocap": keys}, "test")


@pytest.mark.parametrize(
    ("keys", "kind", "settings"),
    [
        ({"system": "vicon", "source": "datastream"}, "vicon", {"hostname": "127.0.0.1:801"}),
        ({"system": "qualisys", "server": "qtm"}, "qualisys", {"hostname": "qtm", "port": "22222"}),
        ({"system": "vrpn", "server": "lab:3884"}, "vrpn", {"hostname": "lab:3884"}),
        (
            {"system": "optitrack", "server": "10.0.0.7", "interface": "10.0.0.2"},
            "optitrack",
            {"hostname": "10.0.0.7", "interface_ip": "10.0.0.2", "port_command": "1510"},
        ),
    ],
    ids=lambda one: one if isinstance(one, str) else "",
)
def test_one_line_names_a_system_and_its_server(keys: dict[str, object], kind: str, settings: dict[str, str]) -> None:
    section = mocap(**keys).cameras
    assert section is not None
    assert section.reader == "sdk"
    assert section.connection == (kind, settings)


@pytest.mark.parametrize(
    ("sections", "said"),
    [
        ({"vicon": {}, "mocap": {}}, "[vicon] and [mocap] both name the cameras: keep one"),
        ({"mocap": {"system": "vrpn", "port": 3883}}, "of Tracker's stream, but system = 'vrpn': remove it"),
        ({"mocap": {"system": "vrpn", "interface": "10.0.0.1"}}, "interface: of optitrack"),
        ({"mocap": {"system": "apriltag"}}, "apriltag.tag_size is missing"),
        ({"mocap": {"system": "qualisys", "apriltag": {"tag_size": 0.03}}}, "[mocap.apriltag] is of system"),
        ({"mocap": {"system": "apriltag", "apriltag": {"tag_size": 0.03, "base_tag": 0}}}, "need different ids"),
        ({"mocap": {"system": "vrpn", "server": "lab:"}}, "has the form HOST or HOST:PORT"),
    ],
)
def test_keys_that_do_not_fit_the_system_are_refused_by_name(sections: dict[str, object], said: str) -> None:
    with pytest.raises(ConfigError) as error:
        check_config(sections, "test")
    assert said in str(error.value)


def test_a_section_vicon_stays_what_it_was() -> None:
    section = check_config({"vicon": {"port": 51002}}, "test").cameras
    assert section is not None
    assert (section.key, section.reader, section.port, section.polled_for) == ("vicon", "udp", 51002, None)


def test_keys_of_another_system_at_their_defaults_are_no_mistake() -> None:
    """As where the example with every key is copied, and a system chosen in it."""
    assert mocap(system="vrpn", port=51001, interface="0.0.0.0", source="udp").cameras is not None
