"""`tendond mocap` with tags: the driver reads a video file, a named pipe, and a camera that is not there."""

import os
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tendond.cli.doctor import camera
from tendond.cli.doctor.check import CheckOutcome
from tendond.cli.doctor.check import Rig as DoctorRig
from tendond.drivers.apriltag.calibration import save_camera
from tendond.drivers.apriltag.source import WRONG_SIZE, TagSource
from tendond.schemas.config.mocap import MocapSection
from tendond.schemas.config.rig import RigConfig, check_config
from tests.rig.mocap.pictures import CAMERA, Grey, facing, render, tag
from tests.rig.tracker import free_port
from tests.rig.vicon.listener import PATIENCE_SECONDS, listening

pytestmark = pytest.mark.rig

SIZE = 0.04
BASE = facing(-0.08, -0.05, 0.4, (0.3, 0.1, 0.0))
RATE = 20.0


def tip(count: int) -> tuple[float, float, float]:
    return 0.04 + 0.002 * count, 0.03, 0.42


def picture(count: int, *, hidden: bool = False) -> Grey:
    base, at = tag(1, SIZE, BASE), tag(0, SIZE, facing(*tip(count), (0.2, -0.3, 0.5)))
    return render([base] if hidden else [base, at], seed=count)


@pytest.fixture(scope="module")
def video(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six pictures with a moving tip, two without it, two with it again; each is shown for a fifth of a second."""
    path = tmp_path_factory.mktemp("video") / "tags.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"FFV1"), RATE, (CAMERA.width, CAMERA.height), False)
    assert writer.isOpened()
    for count in range(10):
        shown = picture(count, hidden=count in (6, 7))
        for _ in range(4):
            writer.write(shown)
    writer.release()
    return path


def config_of(folder: Path, video: object, **keys: object) -> RigConfig:
    save_camera(CAMERA, folder / "camera.toml")
    section = {"system": "apriltag", "apriltag": {"video": str(video), "tag_size": SIZE}, **keys}
    endpoint = f"tcp/127.0.0.1:{free_port(socket.SOCK_STREAM)}"
    return check_config({"rig": {"name": "rig"}, "bus": {"endpoint": endpoint}, "mocap": section}, "test")


def expected(count: int) -> np.ndarray:
    return np.asarray(BASE.rotation.T @ (np.array(tip(count)) - BASE.position))


def test_tags_of_a_video_become_poses_of_the_tip_in_the_bases_frame_within_a_millimetre(
    video: Path, tmp_path: Path
) -> None:
    with listening(config_of(tmp_path, video), tmp_path) as listener:
        listener.until(lambda one: any("has ended" in line for line in one.said))
        listener.until(lambda one: bool(one.poses))
        time.sleep(0.1)
        listener.until(lambda one: True)
    valid = [pose for pose in listener.poses if pose.valid]
    assert len(valid) >= 8
    for pose in valid:
        off = [float(np.linalg.norm(expected(count) - pose.position)) for count in (0, 1, 2, 3, 4, 5, 8, 9)]
        assert min(off) < 1e-3
        w, *xyz = pose.orientation
        turned = Rotation.from_matrix(BASE.rotation).inv() * Rotation.from_matrix(
            facing(0, 0, 1, (0.2, -0.3, 0.5)).rotation
        )
        assert (Rotation.from_quat([*xyz, w]) * turned.inv()).magnitude() < 0.02
    hidden = [pose for pose in listener.poses if not pose.valid]
    assert hidden
    assert any(line == "no valid pose: 'tip' hidden" for line in listener.said)
    stamps = [pose.stamp_ns for pose in listener.poses]
    assert stamps == sorted(stamps)


def test_pictures_come_through_a_named_pipe_as_they_are_written(video: Path, tmp_path: Path) -> None:
    pipe = tmp_path / "camera"
    os.mkfifo(pipe)

    def write() -> None:
        pipe.write_bytes(video.read_bytes())

    with listening(config_of(tmp_path, pipe), tmp_path) as listener:
        writing = threading.Thread(target=write, daemon=True)
        writing.start()
        listener.until(lambda one: any(pose.valid for pose in one.poses))
        writing.join(PATIENCE_SECONDS)
    pose = next(pose for pose in listener.poses if pose.valid)
    assert min(float(np.linalg.norm(expected(count) - pose.position)) for count in range(10)) < 1e-3


def test_a_camera_that_is_not_there_is_named_and_tried_again(video: Path, tmp_path: Path) -> None:
    later = tmp_path / "later.avi"
    with listening(config_of(tmp_path, later), tmp_path) as listener:
        listener.until(
            lambda one: any(f"no picture from {later}: is the camera connected" in line for line in one.said)
        )
        later.with_suffix(".new").write_bytes(video.read_bytes())
        later.with_suffix(".new").rename(later)
        listener.until(lambda one: any(f"pictures from {later} again" in line for line in one.said))
        listener.until(lambda one: any(pose.valid for pose in one.poses))


def test_a_tag_twice_in_the_picture_and_a_picture_of_another_size_give_no_pose(tmp_path: Path) -> None:
    from tendond.drivers.apriltag.video import Picture

    config = config_of(tmp_path, tmp_path / "none.avi")
    assert isinstance(config.mocap, MocapSection)
    source = TagSource(config.mocap, tmp_path)
    try:
        twice = render(
            [
                tag(0, SIZE, facing(-0.1, 0.0, 0.4)),
                tag(0, SIZE, facing(0.1, 0.0, 0.4)),
                tag(1, SIZE, facing(0.0, 0.1, 0.4)),
            ]
        )
        frame = source._frame(Picture(0, twice, 0))
        assert frame.objects["tip"] is None
        assert frame.faults["tip"] == "twice in the picture"
        assert frame.objects["base"] is not None
        source.video._give(np.zeros((100, 100), np.uint8), time.monotonic_ns())
        assert source.receive() is None
        assert source.counts[WRONG_SIZE] == 1
        assert any("pictures of 100 x 100 px, but the calibration is of 640 x 480" in line for line in source.news())
    finally:
        source.close()


def test_a_missing_calibration_is_refused_in_one_line_with_the_command_that_makes_one(tmp_path: Path) -> None:
    file = tmp_path / "rig.toml"
    file.write_text('[mocap]\nsystem = "apriltag"\napriltag.tag_size = 0.04\n')
    ended = subprocess.run(
        [sys.executable, "-m", "tendond.cli", "mocap", "-c", str(file)], capture_output=True, text=True, timeout=60
    )
    assert ended.returncode == 1
    last = ended.stderr.splitlines()[-1]
    assert last.endswith(
        "camera.toml: cannot be read: No such file or directory; write one with `tendond mocap calibrate`"
    )
    assert "Traceback" not in ended.stderr


@pytest.mark.parametrize(
    ("kind", "outcome", "part"),
    [
        ("tags", CheckOutcome.WARN, "'tip' in"),
        ("nothing", CheckOutcome.FAIL, "no picture from"),
        ("no calibration", CheckOutcome.FAIL, "write one with `tendond mocap calibrate`"),
    ],
)
def test_the_doctor_looks_at_the_tags(
    kind: str, outcome: CheckOutcome, part: str, video: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the video the tip is hidden for a fifth of the time."""
    monkeypatch.setattr(camera, "OPEN_SECONDS", 20.0 if kind == "tags" else 1.0)
    config = config_of(tmp_path, video if kind == "tags" else tmp_path / "none.avi")
    if kind == "no calibration":
        (tmp_path / "camera.toml").unlink()
    result = camera.tags(DoctorRig(config, tmp_path / "rig.toml", tmp_path))
    assert result is not None
    assert result.outcome is outcome, result
    assert part in result.finding
    if kind == "tags":
        assert "pictures per second" in result.finding
        assert "reprojection error 0." in result.finding
