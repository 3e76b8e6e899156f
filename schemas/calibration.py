"""Calibration of a rig: zero, sign and spool of each tendon's servo."""

import math
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
        ticks_per_turn: positions in a turn of the servo.
    """

    servo: Annotated[int, Field(ge=0, le=252)]
    zero: Annotated[int, Field(ge=-(2**31), le=2**31 - 1)]
    sign: Literal[-1, 1]
    spool_radius: Annotated[float, Field(gt=0.0, le=0.2)]
    ticks_per_turn: Annotated[int, Field(gt=0, le=2**24)] = 4096

    @property
    def tick(self) -> float:
        """Unit of the servo's positions [rad]."""
        return 2.0 * math.pi / self.ticks_per_turn


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
