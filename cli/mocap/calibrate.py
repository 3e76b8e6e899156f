"""`tendond mocap calibrate`: a camera's intrinsics from pictures, a video or a device."""

import time
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from tendond.cli.common import say
from tendond.drivers.apriltag.calibration import CameraError, save_camera
from tendond.drivers.apriltag.chessboard import BoardViews
from tendond.drivers.apriltag.video import Video

Grey = NDArray[np.uint8]

PICTURES = {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp", ".pgm", ".ppm"}
VIDEO_SECONDS = 0.25
"""Time between two pictures of a video that are looked at [s]: the board moves on by hand."""

DEVICE_SECONDS = 180.0
"""Longest time to look at a device [s]."""

SILENCE_SECONDS = 10.0
"""Longest wait for a device's first picture [s]."""


def run_calibrate(sources: list[str], out: Path, *, board: tuple[int, int], square: float, views_max: int) -> None:
    """Calibrate, and write the file; see `tendond mocap calibrate --help`.

    Raises:
        CameraError: a source cannot be read, the views do not determine the camera, or the file cannot be written.
    """
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # errors are lines of this program
    found = BoardViews(*board, square)
    for source in sources:
        for grey, name in _pictures(source):
            if found.add(grey, name):
                say(f"view {len(found.names)}: {name}")
            if len(found.names) >= views_max:
                break
    result = found.calibrate()
    save_camera(result.camera, out)
    camera = result.camera
    print(
        f"{out}: {camera.views} views, reprojection error {camera.error:.3f} px (worst {result.worst_error:.3f} px, in"
        f" {result.worst}); focal length {camera.focal[0]:.1f}, {camera.focal[1]:.1f} px"
    )


def _pictures(source: str) -> Iterator[tuple[Grey, str]]:
    """Yield the pictures of a source, with a name for each.

    Raises:
        CameraError: it cannot be read.
    """
    path = Path(source)
    if path.is_dir():
        files = sorted(one for one in path.iterdir() if one.suffix.lower() in PICTURES)
        if not files:
            raise CameraError(f"{path}: has no pictures ({', '.join(sorted(PICTURES))})")
        for one in files:
            yield _picture(one), str(one)
    elif path.suffix.lower() in PICTURES:
        yield _picture(path), source
    elif source.startswith("/dev/video"):
        yield from _of_device(source)
    else:
        yield from _of_video(source)


def _picture(path: Path) -> Grey:
    try:
        data = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    except OSError as error:
        raise CameraError(f"{path}: cannot be read: {error.strerror}") from error
    pixels = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE) if data.size else None
    if pixels is None:
        raise CameraError(f"{path}: is no picture that OpenCV reads: give PNG or JPEG")
    return np.asarray(pixels, dtype=np.uint8)


def _of_video(source: str) -> Iterator[tuple[Grey, str]]:
    """Yield a picture of a video file each `VIDEO_SECONDS`."""
    try:
        Path(source).open("rb").close()
    except OSError as error:
        raise CameraError(f"{source}: cannot be read: {error.strerror}") from error
    capture = cv2.VideoCapture(source, cv2.CAP_FFMPEG)
    every = max(1, round(VIDEO_SECONDS * max(capture.get(cv2.CAP_PROP_FPS), 1.0)))
    count = 0
    try:
        while capture.grab():
            if count % every == 0:
                read, pixels = capture.retrieve()
                if read:
                    yield np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY), dtype=np.uint8), f"{source}, {count}"
            count += 1
    finally:
        capture.release()
    if not count:
        raise CameraError(f"{source}: is no video that OpenCV reads, and no picture")


def _of_device(source: str) -> Iterator[tuple[Grey, str]]:
    """Yield what a device shows, until there are enough views."""
    say(f"show the board to {source}: move and tilt it, up to the edges of the picture; it ends by itself")
    video, began, heard = Video(source), time.monotonic(), False
    try:
        while time.monotonic() < began + DEVICE_SECONDS:
            picture = video.next(VIDEO_SECONDS)
            if picture is not None:
                heard = True
                yield picture.pixels, f"{source}, {picture.number}"
            elif not heard and time.monotonic() > began + SILENCE_SECONDS:
                raise CameraError(f"no picture from {source} in {SILENCE_SECONDS:g} s: is it connected, and free?")
    finally:
        video.close()
