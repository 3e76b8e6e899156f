"""`tendond rig vicon` where several senders, objects or addresses could be meant."""

import math
import socket
import struct
import time

import pytest

from tendond.drivers.host import Host
from tendond.drivers.mocap.process import MocapDriver
from tendond.drivers.vicon import sockets
from tendond.drivers.vicon.packet import Block, ObjectReading, build
from tendond.drivers.vicon.sockets import ViconError
from tendond.drivers.vicon.udp import UdpSource
from tendond.schemas.config.vicon import ViconSection
from tests.rig.tracker import BASE, TIP, Tracker, free_port
from tests.rig.vicon.listener import driver

pytestmark = pytest.mark.rig


def test_a_second_driver_on_the_same_port_is_refused_in_one_line() -> None:
    with driver() as (listener, tracker):
        listener.heard(tracker)
        with pytest.raises(ViconError, match=r"cannot listen on UDP .*another driver running"):
            MocapDriver(listener.config, listener.section, Host(lambda: False, print)).run()


def test_other_groups_objects_cost_the_robot_no_pose_and_are_named_once() -> None:
    others: list[tuple[bytes, float]] = [
        ("Körper".encode("latin-1"), 1.0),
        ("Prüfkörper-Nr-12-größer".encode()[:24], 1.0),
        (b"Paket2\t", 1.0),
        (b"wand", math.nan),
        (b"drone", 1.0),
        (b"drone", 2.0),
    ]
    with driver() as (listener, tracker):
        listener.heard(tracker)
        for _ in range(3):
            packet = bytearray(build(Block(tracker.frame, {"tip": TIP, "base": BASE})))
            at = 5 + 2 * 75
            for name, x in others:
                packet[at : at + 75] = struct.pack("<BH24s6d", 0, 72, name, x, 2.0, 3.0, 0.0, 0.0, 0.1)
                at += 75
            packet[4] = 2 + len(others)
            tracker.send_bytes(bytes(packet))
            tracker.frame += 1
        listener.until(lambda one: len(one.poses) >= 3)
    assert [pose.valid for pose in listener.poses] == [True] * 3
    named = [line for line in listener.said if line.startswith("another object")]
    assert len(named) == 5
    assert any("'wand', is passed over: not finite" in line for line in named)
    assert any("'drone', is passed over: twice in the frame" in line for line in named)


def test_a_tip_with_a_number_that_is_none_or_there_twice_gives_invalid_poses_by_name() -> None:
    with driver() as (listener, tracker):
        listener.heard(tracker)
        for x, y in ((math.nan, math.nan), (1.0, 2.0)):
            packet = bytearray(build(Block(tracker.frame, {"base": BASE, "tip": TIP, "also": TIP})))
            for at, value in ((5 + 75, x), (5 + 150, y)):
                packet[at + 3 : at + 35] = struct.pack("<24sd", b"tip", value)
            tracker.send_bytes(bytes(packet))
            tracker.frame += 1
        listener.until(lambda one: len(one.poses) >= 2)
    assert [pose.valid for pose in listener.poses] == [False, False]
    assert [line for line in listener.said if "no valid pose" in line] == [
        "no valid pose: 'tip' not finite",
        "no valid pose: 'tip' twice in the frame",
    ]


def test_a_second_sender_of_the_same_objects_is_counted_and_named_and_gives_no_pose() -> None:
    moved = ObjectReading((1500.0, 210.0, 550.0), TIP.rotation)
    with driver(silence=1000.0) as (listener, tracker), Tracker(listener.section.port) as other:
        listener.heard(tracker)
        other.frame = tracker.frame + 1
        for _ in range(5):
            other.send({"tip": moved, "base": BASE})
            tracker.send({"tip": TIP, "base": BASE})
        listener.until(lambda one: len(one.poses) >= 5)
        time.sleep(0.1)
    assert len(listener.poses) == 5
    assert len({pose.position for pose in listener.poses}) == 1
    assert any(f"packets of {other.sender} are passed over" in line for line in listener.said)
    assert any("5 of another sender" in line for line in listener.said)


def test_another_sender_takes_over_once_the_first_has_been_silent() -> None:
    with driver(silence=0.2) as (listener, tracker), Tracker(listener.section.port) as other:
        listener.heard(tracker)
        listener.until(lambda one: bool(one.poses), lambda: other.send({"tip": TIP, "base": BASE}))
        assert any(f"the robot's objects come from {other.sender}" in line for line in listener.said)


def test_packets_from_another_address_than_the_configured_sender_give_no_pose() -> None:
    with driver(sender="127.0.0.7") as (listener, tracker):
        listener.until(
            lambda one: any("vicon.sender is 127.0.0.7" in line for line in one.said),
            lambda: tracker.send({"tip": TIP, "base": BASE}),
        )
        time.sleep(0.1)
    assert not listener.poses


@pytest.mark.parametrize("broadcast", ["127.255.255.255", "255.255.255.255"])
def test_broadcasts_are_received_on_a_cards_own_address_too(broadcast: str) -> None:
    with driver() as (listener, _), Tracker(listener.section.port, broadcast) as tracker:
        listener.until(lambda one: bool(one.poses), lambda: tracker.send({"tip": TIP, "base": BASE}))
    assert listener.poses[0].valid


def test_a_multicast_group_is_joined() -> None:
    group = "239.255.77.1"
    with driver(multicast=group) as (listener, _), Tracker(listener.section.port, group) as tracker:
        listener.until(lambda one: bool(one.poses), lambda: tracker.send({"tip": TIP, "base": BASE}))
    assert listener.poses[0].valid


def test_a_group_that_cannot_be_joined_and_a_group_for_an_address_are_refused_in_a_line(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with pytest.raises(ValueError, match=r"multicast group: set multicast"):
        ViconSection(address="239.255.77.1")
    join = sockets._member
    monkeypatch.setattr(sockets, "_member", lambda group, address, port, key: join(group, "192.0.2.77", port, key))
    section = ViconSection(address="127.0.0.1", multicast="239.255.77.1", port=free_port(socket.SOCK_DGRAM))
    with pytest.raises(ViconError, match=r"cannot join the multicast group 239\.255\.77\.1"):
        UdpSource(section)
