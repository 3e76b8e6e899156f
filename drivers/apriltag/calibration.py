"""The camera's calibration file: TOML, written whole, read strictly."""

import tomllib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from tendond import TendondError
from tendond.schemas.camera import CameraCalibration

HINT = "write one with `tendond mocap calibrate`"


class CameraError(TendondError):
    """Pictures of the camera or its calibration cannot be used."""


def load_camera(path: Path) -> CameraCalibration:
    """Read a calibration.

    Raises:
        CameraError: the file cannot be read, or is no calibration.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise CameraError(f"{path}: cannot be read: {error.strerror}; {HINT}") from error
    except ValueError as error:  # of TOML, and of bytes that are no text
        raise CameraError(f"{path}: is not TOML: {error}; {HINT}") from error
    try:
        return CameraCalibration.model_validate(data)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise CameraError(f"{path}: is no camera's calibration: {where}: {first['msg']}; {HINT}") from error


def save_camera(camera: CameraCalibration, path: Path) -> None:
    """Write a calibration; an unfinished one never has the file's name.

    Raises:
        CameraError: the file cannot be written.
    """
    values = camera.model_dump()
    lines = ["# Intrinsics of a camera, by tendond mocap calibrate; lengths in pixels"]
    for key, value in values.items():
        lines.append(f"{key} = {list(value) if isinstance(value, tuple) else value!r}".replace("'", '"'))
    unfinished = path.with_name(path.name + ".new")
    try:
        unfinished.write_text("\n".join(lines) + "\n", encoding="utf-8")
        unfinished.replace(path)
    except OSError as error:
        raise CameraError(f"{path}: cannot be written: {error.strerror}") from error


def matrix(camera: CameraCalibration) -> NDArray[np.float64]:
    """Return the camera matrix, shape (3, 3)."""
    (fx, fy), (cx, cy) = camera.focal, camera.centre
    return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])


def distortion(camera: CameraCalibration) -> NDArray[np.float64]:
    """Return the coefficients of the lens, shape (5,)."""
    return np.array(camera.distortion)
