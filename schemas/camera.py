"""Calibration of a camera: its intrinsics, as `tendond mocap calibrate` writes them."""

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from tendond.schemas.base import SCHEMA_VERSION, Schema

Pixels = Annotated[int, Field(ge=16, le=16384)]
Numbers = Annotated[float, Field(gt=-1e6, lt=1e6)]


class CameraCalibration(Schema):
    """Intrinsics of a camera: a pinhole with the lens distortion of Brown (1966), as OpenCV has it.

    Attributes:
        width: width of the pictures [px]. height: height of them [px].
        focal: focal lengths along x and y [px].
        centre: principal point x, y, from the centre of the top left pixel [px].
        distortion: k1, k2, p1, p2, k3 [-].
        error: reprojection error, root mean square over all corners [px].
        views: number of views of the board that were used.
        date: day of the calibration, ISO 8601, UTC.
    """

    version: Literal[1] = SCHEMA_VERSION
    width: Pixels
    height: Pixels
    focal: tuple[Annotated[float, Field(gt=1.0, lt=1e6)], Annotated[float, Field(gt=1.0, lt=1e6)]]
    centre: tuple[Numbers, Numbers]
    distortion: tuple[Numbers, Numbers, Numbers, Numbers, Numbers] = (0.0, 0.0, 0.0, 0.0, 0.0)
    error: Annotated[float, Field(ge=0.0, lt=1e3)]
    views: Annotated[int, Field(ge=0)]
    date: str = ""

    @model_validator(mode="after")
    def _finite(self) -> "CameraCalibration":
        if not all(map(math.isfinite, (*self.focal, *self.centre, *self.distortion))):
            raise ValueError("has a number that is not finite")
        return self
