"""Qualisys and VRPN through the real child process; a stand-in for `motioncapture`, with the manners of its clients."""

import os
import socket
from pathlib import Path

import numpy as np
import pytest

from tendond.schemas.config.rig import check_config
from tests.rig.tracker import free_port
from tests.rig.vicon.listener import listening

pytestmark = pytest.mark.rig

MOTIONCAPTURE = """
import time
from types import SimpleNamespace as N

class Client:
    def __init__(self, kind):
        self.kind, self.count, self.start = kind, 0, time.monotonic()
    def waitForNextFrame(self):
        time.sleep(0.01)
        self.count += 1
    @property
    def rigidBodies(self):
        one = N(w=1.0, x=0.0, y=0.0, z=0.0)
        noise = 1e-6 * self.count
        tip = N(position=(0.5 + noise, 0.5, 0.8), rotation=one)
        base = N(position=(0.5 + noise, 0.5, 0.3), rotation=one)
        if self.kind == "qualisys":  # a frame has all bodies; one that is not seen is not a number
            nan = float("nan")
            return {"tip": tip if self.count % 10 else N(position=(nan,) * 3, rotation=one), "base": base}
        return ({}, {"tip": tip}, {"base": base})[self.count % 3]  # VRPN: whatever came

def connect(kind, settings):
    assert (kind, settings) in (("qualisys", {"hostname": "lab", "port": "22222"}), ("vrpn", {"hostname": "lab:3883"}))
    return Client(kind)
"""


@pytest.mark.parametrize("system", ["qualisys", "vrpn"])
def test_a_system_gives_poses_by_its_name_alone(system: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "motioncapture.py").write_text(MOTIONCAPTURE)
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}:{os.environ.get('PYTHONPATH', '')}")
    monkeypatch.syspath_prepend(tmp_path)
    endpoint = f"tcp/127.0.0.1:{free_port(socket.SOCK_STREAM)}"
    mocap = {"system": system, "server": "lab", "gravity_tolerance": 3.14, "hold": 1.0}
    config = check_config({"rig": {"name": "rig"}, "bus": {"endpoint": endpoint}, "mocap": mocap}, "test")
    with listening(config) as listener:
        listener.until(lambda one: len(one.poses) >= 30)
    valid = [pose for pose in listener.poses if pose.valid]
    assert len(valid) >= 25
    for pose in valid:
        np.testing.assert_allclose(pose.position, (0.0, 0.0, 0.5), atol=1e-4)
    if system == "qualisys":
        assert any(line == "no valid pose: 'tip' not finite" for line in listener.said)
        assert len(valid) < len(listener.poses)
    else:  # two of three polls are without the tip, which is no occlusion; a busy machine may make a real one
        assert len(valid) > 0.8 * len(listener.poses)
    assert valid[0].source.startswith("mocap-")
