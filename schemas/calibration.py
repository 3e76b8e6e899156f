"""Calibration of a rig: zero, sign and spool of each tendon's servo."""

from typing import Annotated, Literal

from pydantic import Field

from tendond.schemas.base import SCHEMA_VERSION, Schema


class TendonCalibration(Schema):
    """Calibration of one tendon.

    Attributes:
        servo: id of its servo.
        zero: position at which the tendon of the straight robot becomes taut [ticks].
        sign: +1 where larger positions pull the tendon.
        spool_radius: radius to the middle of the tendon [m].
    """

    servo: Annotated[int, Field(ge=0, le=252)]
    zero: Annotated[int, Field(ge=-1_048_575, le=1_048_575)]
    sign: Literal[-1, 1]
    spool_radius: Annotated[float, Field(gt=0.0, le=0.2)]


class Calibration(Schema):
    """Calibration of a rig.

    Attributes:
        rig: name of the rig that it was made on.
        date: day of the last change, ISO 8601, UTC.
        tendons: calibrations in the order of the configuration; an unfinished calibration has fewer.
    """

    version: Literal[1] = SCHEMA_VERSION
    rig: str
    date: str
    tendons: tuple[TendonCalibration, ...]
