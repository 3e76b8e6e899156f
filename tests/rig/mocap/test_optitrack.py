"""`tendond mocap` with a scripted Motive: NatNet's bytes through the real `motioncapture` package."""

import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tendond.schemas.config.rig import RigConfig, check_config
from tests.rig.mocap.natnet import Body, Motive
from tests.rig.tracker import free_port
from tests.rig.vicon.listener import PATIENCE_SECONDS, Listener, listening

pytestmark = [
    pytest.mark.rig,
    pytest.mark.skipif(
        subprocess.run([sys.executable, "-c", "import motioncapture"], capture_output=True).returncode != 0,
        reason="the extra [vicon-sdk] is not installed",
    ),
]

IDS = {"other": 3, "tip": 7, "base": 9}
TURN = Rotation.from_rotvec([0.3, -0.5, 0.8])


def config_of(motive: Motive, **keys: object) -> RigConfig:
    section = {"system": "optitrack", "server": f"127.0.0.1:{motive.port}", "interface": "127.0.0.1", **keys}
    endpoint = f"tcp/127.0.0.1:{free_port(socket.SOCK_STREAM)}"
    return check_config({"rig": {"name": "rig"}, "bus": {"endpoint": endpoint}, "mocap": section}, "test")


def body(x: float, turn: Rotation = TURN, *, tracked: bool = True) -> Body:
    qx, qy, qz, qw = turn.as_quat().tolist()
    return (x, 0.25, 0.75), (qx, qy, qz, qw), tracked


def moving(motive: Motive, count: int, *, tip_tracked: bool = True) -> None:
    """Send a frame: the base stands still but for a noise of a micrometre, as a real one does."""
    base = body(0.1 + 1e-6 * (count % 7))
    motive.send({"other": body(9.0), "tip": body(0.5 + 1e-3 * count, tracked=tip_tracked), "base": base})
    time.sleep(0.01)


def heard(listener: Listener, motive: Motive) -> None:
    sent = iter(range(100_000))
    listener.until(lambda one: bool(one.poses), lambda: moving(motive, next(sent)))


@pytest.mark.parametrize("version", [(3, 1), (4, 1)], ids=str)
def test_rigid_bodies_of_natnet_become_poses_in_the_bases_frame(version: tuple[int, int]) -> None:
    with Motive(version, IDS) as motive, listening(config_of(motive, gravity_tolerance=3.14)) as listener:
        heard(listener, motive)
        listener.poses.clear()
        for count in range(40):
            moving(motive, count)
        listener.until(lambda one: len(one.poses) >= 20)
    assert all(pose.valid for pose in listener.poses)
    for pose in listener.poses:
        along = np.add(TURN.apply(pose.position), (0.1, 0.0, 0.0))  # back in Motive's world, less y and z
        np.testing.assert_allclose(along[1:], 0.0, atol=2e-5)  # of floats of four bytes, and the noise
        step = (along[0] - 0.5) / 1e-3
        assert abs(step - round(step)) < 0.02
        np.testing.assert_allclose(np.abs(pose.orientation), [1.0, 0.0, 0.0, 0.0], atol=1e-5)


def test_a_body_that_motive_does_not_track_is_occluded_and_named() -> None:
    with Motive((4, 1), IDS) as motive, listening(config_of(motive, gravity_tolerance=3.14)) as listener:
        heard(listener, motive)
        listener.until(
            lambda one: any("no valid pose: 'tip' without a new measurement" in line for line in one.said),
            lambda: moving(motive, 1, tip_tracked=False),
        )
        listener.until(lambda one: not one.poses[-1].valid)


def test_a_frame_that_is_repeated_is_never_a_new_pose() -> None:
    """The package gives the last bodies again after any other packet; a server may send one frame for ever."""
    with Motive((4, 1), IDS) as motive, listening(config_of(motive, gravity_tolerance=3.14)) as listener:
        heard(listener, motive)
        moving(motive, 500)
        listener.until(lambda one: one.poses[-1].position[0] > 0.0 and len(one.poses) > 1)
        last = len([pose for pose in listener.poses if pose.valid])

        def repeat() -> None:
            motive.send_bytes(b"\x63\x00\x04\x00more")
            motive.send({"tip": body(1.0), "base": body(0.1)})
            time.sleep(0.01)

        listener.until(lambda one: not one.poses[-1].valid, repeat)
        for _ in range(20):
            repeat()
        listener.until(lambda one: not one.poses[-1].valid, repeat)
    assert len([pose for pose in listener.poses if pose.valid]) <= last + 2  # the frame itself, and one in flight


def test_the_command_runs_the_configured_system_and_ends_with_0_on_sigterm(tmp_path: Path) -> None:
    file = tmp_path / "rig.toml"
    endpoint = f"tcp/127.0.0.1:{free_port(socket.SOCK_STREAM)}"
    file.write_text(f'[bus]\nendpoint = "{endpoint}"\n[mocap]\nsystem = "optitrack"\nserver = "127.0.0.1:1511"\n')
    with subprocess.Popen(
        [sys.executable, "-m", "tendond.cli", "mocap", "-c", str(file)], stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr is not None
        first = process.stderr.readline()
        process.terminate()
        rest = process.stderr.read()
        assert process.wait(PATIENCE_SECONDS) == 0
    assert first == "tendond: rig 'paper': tip 'tip' relative to 'base', from Motive at 127.0.0.1:1511\n"
    assert "Traceback" not in rest
