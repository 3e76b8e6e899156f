"""`tendond rig vicon` against a scripted Tracker on a real UDP port, with a real Zenoh hub."""

import math
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tendond.drivers.vicon.packet import ObjectReading
from tendond.drivers.vicon.udp import UdpSource
from tendond.schemas.config.vicon import ViconSection
from tests.rig.tracker import BASE, HIDDEN, OTHER, TIP, Tracker, free_port
from tests.rig.vicon.listener import PATIENCE_SECONDS, driver

pytestmark = pytest.mark.rig


@pytest.mark.parametrize("rate", [100, 500])
def test_every_frame_of_several_objects_becomes_one_pose_of_the_tip_in_the_bases_frame(rate: int) -> None:
    with driver() as (listener, tracker):
        listener.heard(tracker)
        started = time.monotonic()
        for count in range(rate // 5):
            moved = ObjectReading((TIP.translation[0] + count, *TIP.translation[1:]), TIP.rotation)
            tracker.send({"drone": OTHER, "base": BASE, "tip": moved})
            time.sleep(max(0.0, started + count / rate - time.monotonic()))
        listener.until(lambda one: len(one.poses) >= rate // 5)
    base = Rotation.from_euler("XYZ", BASE.rotation)
    turned = base.inv() * Rotation.from_euler("XYZ", TIP.rotation)
    for count, pose in enumerate(listener.poses):
        offset = np.subtract(np.add(TIP.translation, (count, 0.0, 0.0)), BASE.translation)
        assert np.allclose(pose.position, base.inv().apply(offset) * 1e-3, atol=1e-12)
        w, *xyz = pose.orientation
        assert (Rotation.from_quat([*xyz, w]) * turned.inv()).magnitude() < 1e-9
        assert pose.valid
        assert pose.stamp_ns > 0
    sequence = [pose.seq for pose in listener.poses]
    assert sequence == list(range(sequence[0], sequence[0] + len(sequence)))


def test_a_hidden_or_missing_object_gives_invalid_poses_and_is_named() -> None:
    with driver() as (listener, tracker):
        listener.heard(tracker)
        for tip, base in ((HIDDEN, BASE), (TIP, HIDDEN), (TIP, BASE)):
            tracker.send({"tip": tip, "base": base})
        tracker.send({"base": BASE})
        tracker.send({"tip": TIP, "base": BASE})
        listener.until(lambda one: len(one.poses) >= 5)
    assert [pose.valid for pose in listener.poses] == [False, False, True, False, True]
    assert len({pose.position for pose in listener.poses[2:]}) == 1
    assert [line for line in listener.said if "no valid pose" in line] == [
        "no valid pose: 'tip' hidden",
        "no valid pose: 'base' hidden",
        "no valid pose: 'tip' not in the stream",
    ]


def test_garbage_truncated_and_wrong_packets_are_counted_and_give_no_pose() -> None:
    with driver() as (listener, tracker):
        listener.heard(tracker)
        for payload in (b"", b"hello", b"\xff" * 256, bytes(200), b"\x07" * 1024, b"\xa5" * 60000):
            tracker.send_bytes(payload)
        tracker.send({"tip": TIP, "base": BASE})
        listener.until(lambda one: bool(one.poses))
    assert len(listener.poses) == 1
    report = next(line for line in listener.said if "since the last report" in line)
    assert "4 wrong size" in report
    assert "2 truncated" in report


def test_gaps_late_frames_and_a_restart_of_tracker() -> None:
    with driver() as (listener, tracker):
        listener.heard(tracker)
        for number in (5000, 5001, 5005, 5003, 5005, 1, 2):
            tracker.send({"tip": TIP, "base": BASE}, number)
        listener.until(lambda one: len(one.poses) >= 5)
        time.sleep(0.1)
    assert len(listener.poses) == 5
    report = next(line for line in listener.said if "since the last report" in line)
    # 5000 after about 1000, in no time, is a Tracker that was started anew as well
    assert all(part in report for part in ("1 late", "1 duplicate", "2 restarts", "3 frames lost"))


def test_a_frame_split_over_small_packets_gives_one_pose_with_the_base_of_its_own_frame() -> None:
    """Packets of 256 bytes hold three objects: the base's comes in another than the tip's, and in either order."""
    moved = ObjectReading((1100.0, 200.0, 50.0), BASE.rotation)
    with driver() as (listener, tracker):
        listener.heard(tracker)
        for number, base in ((2000, BASE), (2001, moved)):
            tracker.send({"other": OTHER, "tip": TIP}, number, size=256)
            tracker.send({"base": base}, number, size=256)
        tracker.send({"base": BASE}, 2002, size=256)
        tracker.send({"tip": TIP}, 2002, size=512)
        listener.until(lambda one: len(one.poses) >= 3)
        time.sleep(0.05)
    assert [pose.valid for pose in listener.poses] == [True] * 3
    first, second, third = (np.array(pose.position) for pose in listener.poses)
    np.testing.assert_allclose(np.linalg.norm(second - first), 0.1, atol=1e-12)
    np.testing.assert_array_equal(first, third)


def test_the_configured_euler_order_is_used() -> None:
    orders = {}
    for order in ("XYZ", "ZYX"):
        with driver(euler_order=order) as (listener, tracker):
            listener.heard(tracker)
            tracker.send({"tip": TIP, "base": ObjectReading(BASE.translation, (0.0, 0.0, 0.0))})
            tracker.send({"tip": TIP, "base": ObjectReading(BASE.translation, (0.0, 0.0, 1e-12))})
            listener.until(lambda one: bool(one.poses) and one.poses[-1].valid)
            w, x, y, z = listener.poses[-1].orientation
        orders[order] = Rotation.from_quat([x, y, z, w])
    for order, found in orders.items():
        angles = [TIP.rotation["XYZ".index(letter)] for letter in order]
        assert (found.inv() * Rotation.from_euler(order, angles)).magnitude() < 1e-9


def test_silence_is_reported_once_and_its_end_too() -> None:
    with driver() as (listener, tracker):
        listener.heard(tracker)
        listener.until(lambda one: any("nothing from Tracker" in line for line in one.said))
        listener.until(
            lambda one: any("packets from Tracker again" in line for line in one.said),
            lambda: tracker.send({"tip": TIP, "base": BASE}),
        )
    assert sum("nothing from Tracker" in line for line in listener.said) == 1


def test_a_base_that_is_mounted_otherwise_than_the_model_thinks_gives_no_pose_at_all() -> None:
    with driver(gravity_tolerance=0.17) as (listener, tracker):
        listener.until(
            lambda one: any("base turned against gravity" in line for line in one.said),
            lambda: tracker.send({"tip": TIP, "base": BASE}),
        )
    assert not listener.poses


def test_packets_that_waited_while_the_driver_could_not_run_are_not_taken_for_fresh() -> None:
    section = ViconSection(address="127.0.0.1", port=free_port(socket.SOCK_DGRAM))
    source = UdpSource(section)
    with Tracker(section.port) as tracker:
        for _ in range(3):
            tracker.send({"tip": TIP, "base": BASE})
        time.sleep(0.2)
        assert [source.receive() for _ in range(3)] == [None] * 3
        assert source.counts == {"stale": 3}
        tracker.send({"tip": TIP, "base": BASE})
        before = time.monotonic_ns()
        time.sleep(0.02)
        fresh = source.receive()
        source.close()
    assert fresh is not None
    assert abs(fresh.stamp_ns - before) < 15_000_000


def test_the_command_ends_with_0_on_sigterm_and_says_what_it_does(tmp_path: Path) -> None:
    port = free_port(socket.SOCK_DGRAM)
    endpoint = f"tcp/127.0.0.1:{free_port(socket.SOCK_STREAM)}"
    file = tmp_path / "rig.toml"
    file.write_text(f'[bus]\nendpoint = "{endpoint}"\n[vicon]\nport = {port}\n')
    with subprocess.Popen(
        [sys.executable, "-m", "tendond.cli", "rig", "vicon", "--config", str(file)], stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr is not None
        first = process.stderr.readline()
        process.terminate()
        rest = process.stderr.read()
        assert process.wait(PATIENCE_SECONDS) == 0
    assert first == f"tendond: rig 'paper': tip 'tip' relative to 'base', from UDP port {port}\n"
    assert "Traceback" not in rest


def test_a_tip_that_flickers_does_not_fill_the_run_log() -> None:
    with driver() as (listener, tracker):
        listener.heard(tracker)
        before = len(listener.said)
        for count in range(400):
            tracker.send({"tip": TIP if count % 2 else HIDDEN, "base": BASE})
            time.sleep(0.001)
        listener.until(lambda one: len(one.poses) >= 400)
    assert len(listener.said) - before < 20
    assert any("lines withheld" in line for line in listener.said)


def test_a_base_that_is_rolled_against_gravity_is_reported_while_its_poses_are_used() -> None:
    """Three degrees about the rod's axis; the rod lies with its +x up."""
    lying = {"base_axes": ["+z", "+y", "-x"], "gravity_tolerance": 0.17}
    rolled = ObjectReading(BASE.translation, (math.radians(3.0), 0.0, 0.0))
    with driver(**lying) as (listener, tracker):
        listener.until(
            lambda one: any("turned by 3.0 degrees against gravity" in line for line in one.said),
            lambda: tracker.send({"tip": TIP, "base": rolled}),
        )
        listener.until(lambda one: bool(one.poses), lambda: tracker.send({"tip": TIP, "base": rolled}))
    assert all(pose.valid for pose in listener.poses)
