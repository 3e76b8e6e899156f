"""`tendond rig vicon` with frames of a DataStream server."""

import os
import socket
import time
from pathlib import Path

import numpy as np
import pytest

from tendond.drivers.mocap.frames import Frame
from tendond.drivers.mocap.sdk import SdkSource
from tendond.schemas.config.vicon import ViconSection
from tests.rig.tracker import free_port
from tests.rig.vicon.listener import PATIENCE_SECONDS, Listener, driver

pytestmark = pytest.mark.rig

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


def test_a_datastream_server_that_goes_away_and_comes_back_is_connected_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Real processes and sockets; a stand-in for the vendor's package, which has its manners."""
    (tmp_path / "motioncapture.py").write_text(MOTIONCAPTURE)
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}:{os.environ.get('PYTHONPATH', '')}")
    monkeypatch.syspath_prepend(tmp_path)
    port = free_port(socket.SOCK_STREAM)

    def serve(listener: Listener) -> None:
        """Serve until the driver has given ten poses."""
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
    source = SdkSource(ViconSection(source="datastream", server="lab:801", server_timeout=PATIENCE_SECONDS))
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


def test_an_absent_datastream_server_is_reported_and_tried_again() -> None:
    pytest.importorskip("motioncapture", reason="the extra [vicon-sdk] is not installed")
    server = f"127.0.0.1:{free_port(socket.SOCK_STREAM)}"
    source = SdkSource(ViconSection(source="datastream", server=server, server_timeout=0.8))
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
