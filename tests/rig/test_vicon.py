"""`tendond rig vicon` against a scripted Tracker on a real UDP port, with a real Zenoh hub."""

import math
import os
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zenoh
from scipy.spatial.transform import Rotation

from tendond.daemon.runtime.bus import Hub
from tendond.drivers.vicon import sockets
from tendond.drivers.vicon.datastream import DataStreamSource
from tendond.drivers.vicon.frames import Frame
from tendond.drivers.vicon.packet import Block, ObjectReading, build
from tendond.drivers.vicon.process import ViconDriver
from tendond.drivers.vicon.sockets import ViconError
from tendond.drivers.vicon.udp import UdpSource
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.config.vicon import ViconSection
from tendond.schemas.keys import TIP_POSE, key
from tendond.schemas.messages import TipPose
from tendond.schemas.wire import decode
from tests.rig.tracker import BASE, HIDDEN, OTHER, TIP, Tracker, free_port

pytestmark = pytest.mark.rig

PATIENCE_SECONDS = 60.0
MARK = ObjectReading((500.0, 500.0, 500.0), (0.0, 0.0, 0.0))


class Listener:
    """A running driver, what it publishes and what it says."""

    def __init__(self, config: RigConfig, session: zenoh.Session) -> None:
        assert config.vicon is not None
        self.config, self.section = config, config.vicon
        self.said: list[str] = []
        self.poses: list[TipPose] = []
        self._subscriber = session.declare_subscriber(key(config.rig.name, TIP_POSE), zenoh.handlers.FifoChannel(10000))

    def until(self, wanted: Callable[["Listener"], bool], prod: Callable[[], None] = lambda: None) -> None:
        deadline = time.monotonic() + PATIENCE_SECONDS
        while not wanted(self):
            assert time.monotonic() < deadline, (self.said, self.poses[-3:])
            prod()
            time.sleep(0.005)
            while (sample := self._subscriber.try_recv()) is not None:
                self.poses.append(decode(TipPose, sample.payload.to_bytes()))

    def heard(self, tracker: Tracker) -> None:
        """Send frames until the driver hears them; what came so far is then forgotten."""
        self.until(lambda one: bool(one.poses), lambda: tracker.send({"tip": TIP, "base": BASE}))
        tracker.send({"tip": MARK, "base": BASE})
        marked = self.poses[0].position
        self.until(lambda one: one.poses[-1].position != marked)
        self.poses.clear()


@contextmanager
def driver(**section: Any) -> Iterator[tuple[Listener, Tracker]]:
    """A driver in a thread; base markers stand as the model's gravity wants them unless told otherwise."""
    port = free_port(socket.SOCK_DGRAM)
    vicon = {"address": "127.0.0.1", "port": port, "gravity_tolerance": math.pi, "silence": 0.3, **section}
    endpoint = f"tcp/127.0.0.1:{free_port(socket.SOCK_STREAM)}"
    config = check_config({"rig": {"name": "rig"}, "bus": {"endpoint": endpoint}, "vicon": vicon}, "test")
    ended = threading.Event()
    with Hub(config) as hub, Tracker(port) as tracker:
        listener = Listener(config, hub._session)
        one = ViconDriver(config, listener.section, ended.is_set, listener.said.append)
        thread = threading.Thread(target=one.run)
        thread.start()
        try:
            yield listener, tracker
        finally:
            ended.set()
            thread.join(PATIENCE_SECONDS)
            assert not thread.is_alive()


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


def test_silence_is_said_once_and_its_end_too() -> None:
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


def test_a_second_driver_on_the_same_port_is_refused_in_one_line() -> None:
    with driver() as (listener, tracker):
        listener.heard(tracker)
        with pytest.raises(ViconError, match=r"cannot listen on UDP .*another driver running"):
            ViconDriver(listener.config, listener.section, lambda: False, print).run()


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
    assert first == f"tendond: rig 'paper': tip 'tip' seen from 'base', from UDP port {port}\n"
    assert "Traceback" not in rest


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


def test_packets_from_another_address_than_the_configured_one_give_no_pose() -> None:
    with driver(sender="127.0.0.7") as (listener, tracker):
        listener.until(
            lambda one: any("vicon.sender is 127.0.0.7" in line for line in one.said),
            lambda: tracker.send({"tip": TIP, "base": BASE}),
        )
        time.sleep(0.1)
    assert not listener.poses


@pytest.mark.parametrize("broadcast", ["127.255.255.255", "255.255.255.255"])
def test_what_is_broadcast_is_heard_on_a_cards_own_address_too(broadcast: str) -> None:
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
    with pytest.raises(ValueError, match=r"multicast group: set vicon\.multicast"):
        ViconSection(address="239.255.77.1")
    join = sockets._member
    monkeypatch.setattr(sockets, "_member", lambda group, address, port: join(group, "192.0.2.77", port))
    section = ViconSection(address="127.0.0.1", multicast="239.255.77.1", port=free_port(socket.SOCK_DGRAM))
    with pytest.raises(ViconError, match=r"cannot join the multicast group 239\.255\.77\.1"):
        UdpSource(section)


def test_a_tip_that_flickers_does_not_fill_the_journal() -> None:
    with driver() as (listener, tracker):
        listener.heard(tracker)
        before = len(listener.said)
        for count in range(400):
            tracker.send({"tip": TIP if count % 2 else HIDDEN, "base": BASE})
            time.sleep(0.001)
        listener.until(lambda one: len(one.poses) >= 400)
    assert len(listener.said) - before < 20
    assert any("lines withheld" in line for line in listener.said)


def test_a_base_that_is_rolled_against_gravity_is_said_while_its_poses_are_used() -> None:
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


MOTIONCAPTURE = """
import socket, time
from types import SimpleNamespace as N

class Client:  # connects once, and then waits for a frame for ever, as the vendor's does
    def __init__(self, port):
        self.stream = None
        while self.stream is None:
            try:
                self.stream = socket.create_connection(("127.0.0.1", port))
            except OSError:
                time.sleep(0.05)
    def waitForNextFrame(self):
        while not self.stream.recv(1):
            time.sleep(0.05)
    @property
    def rigidBodies(self):
        turned = N(w=0.7071067811865476, x=0.0, y=-0.7071067811865476, z=0.0)
        tip = N(position=(0.5, 0.5, 0.8), rotation=turned)
        base = N(position=(1.0, 0.5, 0.8), rotation=turned)
        return {"tip": tip, "base": base, "wand": N(position=(float("nan"),) * 3, rotation=turned)}

def connect(kind, settings):
    return Client(int(settings["hostname"].rpartition(":")[2]))
"""


def test_a_datastream_server_that_goes_away_and_comes_back_is_heard_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Real processes and sockets; a stand-in for the vendor's package, which has its manners."""
    (tmp_path / "motioncapture.py").write_text(MOTIONCAPTURE)
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}:{os.environ.get('PYTHONPATH', '')}")
    monkeypatch.syspath_prepend(tmp_path)
    port = free_port(socket.SOCK_STREAM)

    def serve(listener: Listener) -> None:
        """Until the driver has given ten poses."""
        listener.poses.clear()
        with socket.create_server(("127.0.0.1", port)) as server:
            server.settimeout(PATIENCE_SECONDS)
            stream, _ = server.accept()
            with stream:
                listener.until(lambda one: len(one.poses) >= 10, lambda: stream.sendall(b"x"))

    with driver(source="datastream", server=f"127.0.0.1:{port}") as (listener, _):
        serve(listener)
        serve(listener)
    assert all(pose.valid for pose in listener.poses)
    assert any("connecting again" in line for line in listener.said)


def test_a_datastream_frame_becomes_placements_of_the_robots_objects_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The child runs for real; a stand-in for the vendor's package, whose server cannot be had, gives it two frames."""
    (tmp_path / "motioncapture.py").write_text(
        "import time\n"
        "from types import SimpleNamespace as N\n"
        "class Client:\n"
        "    count = 0\n"
        "    def waitForNextFrame(self):\n"
        "        self.count += 1\n"
        "        time.sleep(0.01)\n"
        "    @property\n"
        "    def rigidBodies(self):\n"
        "        w = 1.0 if self.count > 1 else 0.0\n"
        "        return {'tip': N(position=(1.5, -0.25, 0.125), rotation=N(w=w, x=0.0, y=0.0, z=0.0)),\n"
        "                'other': N(position=(float('nan'), 0.0, 0.0), rotation=N(w=0.0, x=0.0, y=0.0, z=0.0))}\n"
        "def connect(kind, settings):\n"
        "    assert (kind, settings) == ('vicon', {'hostname': 'lab:801'})\n"
        "    return Client()\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.syspath_prepend(tmp_path)
    source = DataStreamSource(ViconSection(source="datastream", server="lab:801", server_timeout=PATIENCE_SECONDS))
    try:
        deadline = time.monotonic() + PATIENCE_SECONDS
        frames: list[Frame] = []
        while len(frames) < 2:
            assert time.monotonic() < deadline
            if (frame := source.receive()) is not None:
                frames.append(frame)
    finally:
        source.close()
    untracked, first = frames
    assert untracked.objects == {"tip": None}  # a body that is not tracked has no unit quaternion
    assert set(first.objects) == {"tip"}
    placement = first.objects["tip"]
    assert placement is not None
    np.testing.assert_array_equal(placement.position, [1.5, -0.25, 0.125])
    np.testing.assert_array_equal(placement.rotation, np.eye(3))
    assert not source.counts


def test_a_datastream_server_that_is_not_there_is_said_and_tried_again() -> None:
    pytest.importorskip("motioncapture", reason="the extra [vicon-sdk] is not installed")
    server = f"127.0.0.1:{free_port(socket.SOCK_STREAM)}"
    source = DataStreamSource(ViconSection(source="datastream", server=server, server_timeout=0.8))
    children = {source._child}
    news: list[str] = []
    deadline = time.monotonic() + PATIENCE_SECONDS
    try:
        while len(news) < 2 and time.monotonic() < deadline:
            assert source.receive() is None
            children.add(source._child)
            news += source.news()
    finally:
        source.close()
    assert [line.partition(" in 0.8 s")[0] for line in news] == [f"no frame from the DataStream server {server}"] * 2
    assert all(child.poll() is not None for child in children if child is not None)
