"""A rig's calibration: where each tendon's zero is, which way its servo winds, and on what."""

from typing import Annotated, Literal

from pydantic import Field

from tendond.schemas.base import SCHEMA_VERSION, Schema


class TendonCalibration(Schema):
    """Of one tendon.

    Attributes:
        servo: id of its servo.
        zero: position at which the straight robot's tendon is just not slack [ticks].
        sign: +1 where larger positions wind the tendon up.
        spool_radius: to the middle of the tendon [m].
    """

    servo: Annotated[int, Field(ge=0, le=252)]
    zero: Annotated[int, Field(ge=-1_048_575, le=1_048_575)]
    sign: Literal[-1, 1]
    spool_radius: Annotated[float, Field(gt=0.0, le=0.2)]


class Calibration(Schema):
    """Of a rig.

    Attributes:
        rig: name of the rig that it was made on.
        date: on which it was last changed, ISO 8601, UTC.
        tendons: in the order of the configuration; an unfinished calibration has fewer.
    """

    version: Literal[1] = SCHEMA_VERSION
    rig: str
    date: str
    tendons: tuple[TendonCalibration, ...]
