"""`tendond mocap calibrate` on rendered boards: the camera that rendered them is found, and poor views are refused."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from tendond.drivers.apriltag.calibration import CameraError, load_camera, save_camera
from tendond.drivers.mocap.geometry import Placement
from tests.rig.mocap.pictures import CAMERA, board, facing, render
from tests.unit.cli.commands import few_lines, tendond

BOARD = (7, 5, 0.03)
TILTED = [
    facing(0.0, 0.0, 0.32, (0.0, 0.0, 0.1)),
    facing(0.03, 0.02, 0.34, (0.5, 0.0, 0.0)),
    facing(-0.03, 0.0, 0.34, (-0.5, 0.1, 0.0)),
    facing(0.0, -0.03, 0.33, (0.0, 0.6, 0.0)),
    facing(-0.05, 0.03, 0.36, (0.1, -0.5, 0.2)),
    facing(-0.08, -0.05, 0.42, (0.3, 0.3, 0.0)),
    facing(0.08, 0.05, 0.42, (-0.3, 0.35, 0.3)),
    facing(0.08, -0.06, 0.45, (0.4, -0.3, -0.2)),
    facing(-0.09, 0.06, 0.45, (-0.4, -0.4, 0.0)),
    facing(0.0, 0.05, 0.5, (0.0, 0.0, 1.4)),
]
FRONTAL = [facing(0.03 * x, 0.03 * y, 0.4 + 0.02 * x) for x in (-1, 0, 1) for y in (-1, 0, 1)]


def pictures(folder: Path, views: list[Placement]) -> Path:
    folder.mkdir()
    for number, at in enumerate(views):
        cv2.imwrite(str(folder / f"{number:02d}.png"), render([board(*BOARD, at)], seed=number))
    return folder


@pytest.fixture(scope="module")
def tilted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return pictures(tmp_path_factory.mktemp("views") / "tilted", TILTED)


def calibrate(capsys: pytest.CaptureFixture[str], *sources: Path, out: Path) -> tuple[int, str]:
    options = ["--square", "0.03", "--columns", "7", "--rows", "5", "--out", str(out)]
    ended = tendond(capsys, "mocap", "calibrate", *map(str, sources), *options)
    return ended.status, ended.out + ended.said


def test_the_camera_of_the_pictures_is_found(tilted: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "camera.toml"
    status, said = calibrate(capsys, tilted, out=out)
    assert status == 0, said
    found = load_camera(out)
    assert f"{found.views} views, reprojection error {found.error:.3f} px" in said
    assert found.views == len(TILTED)
    assert 0.0 < found.error < 0.2
    np.testing.assert_allclose(found.focal, CAMERA.focal, rtol=5e-3)
    np.testing.assert_allclose(found.centre, CAMERA.centre, atol=4.0)
    corner = np.array([[[20.0, 20.0]]])  # the lens shifts a corner of the picture as the true one does
    straight = [
        cv2.undistortPoints(
            corner,
            np.array([[one.focal[0], 0.0, one.centre[0]], [0.0, one.focal[1], one.centre[1]], [0.0, 0.0, 1.0]]),
            np.array(one.distortion),
        )
        for one in (found, CAMERA)
    ]
    np.testing.assert_allclose(straight[0], straight[1], atol=0.01)


def test_too_few_and_too_similar_views_are_refused_and_nothing_is_written(
    tilted: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "camera.toml"
    several = [tilted / f"{number:02d}.png" for number in (0, 1, 2, 0, 1, 2, 0, 1, 2)]
    status, said = calibrate(capsys, *several, out=out)
    assert status == 1
    assert "3 distinct views of a board with 7 x 5 inner corners in 9 pictures (0 without it, 6 like another)" in said
    assert not out.exists()


def test_views_from_the_front_alone_are_refused_however_well_they_fit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "camera.toml"
    status, said = calibrate(capsys, pictures(tmp_path / "frontal", FRONTAL), out=out)
    assert status == 1
    assert "tilts differ by" in said or "determine the focal length" in said, said
    assert not out.exists()


@pytest.mark.parametrize(
    ("name", "content", "part"),
    [
        ("absent.png", None, "cannot be read: No such file"),
        ("text.png", b"no picture", "is no picture that OpenCV reads"),
        ("empty.mp4", b"", "is no video that OpenCV reads"),
    ],
)
def test_a_source_that_cannot_be_read_is_named_in_a_line(
    name: str, content: bytes | None, part: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    status, said = calibrate(capsys, path, out=tmp_path / "camera.toml")
    assert status == 1
    assert str(path) in said
    assert part in said
    assert few_lines(said)


def test_a_calibration_is_read_back_as_it_was_written(tmp_path: Path) -> None:
    save_camera(CAMERA, tmp_path / "camera.toml")
    assert load_camera(tmp_path / "camera.toml") == CAMERA


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("[", "is not TOML"),
        ("width = 640", "is no camera's calibration: height"),
        (None, "cannot be read"),
    ],
)
def test_a_calibration_that_is_none_is_refused_with_the_command_that_makes_one(
    text: str | None, part: str, tmp_path: Path
) -> None:
    path = tmp_path / "camera.toml"
    if text is not None:
        path.write_text(text)
    with pytest.raises(CameraError) as error:
        load_camera(path)
    assert part in str(error.value)
    assert "write one with `tendond mocap calibrate`" in str(error.value)
    assert "\n" not in str(error.value)


def test_a_number_that_is_not_finite_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "camera.toml"
    save_camera(CAMERA, path)
    path.write_text(path.read_text().replace("0.05,", "nan,"))
    with pytest.raises(CameraError, match="distortion"):
        load_camera(path)
