"""[teleop]: moving the target by hand."""

from typing import Annotated

from pydantic import Field

from tendond.schemas.base import Schema
from tendond.schemas.config.ranges import Positive

SPEED, ACCELERATION = 0.2, 1.0
"""Default speed [1/s] and acceleration [1/s^2] of the target, of the backbone's length: along it in 5 s, at full speed
after 0.2 s. Chosen."""


class TeleopSection(Schema):
    """[teleop]: bounds of a target that is moved by hand."""

    speed_max: Positive | None = Field(
        None, description="largest speed of the target [m/s]; default: 0.2 lengths of the backbone per second"
    )
    acceleration_max: Positive | None = Field(
        None,
        description="largest acceleration of the target [m/s^2]; default: a length of the backbone per second squared",
    )
    timeout: Annotated[float, Field(gt=0.0, le=2.0)] = Field(
        0.3, description="time without a new request after which the target slows down and holds its place [s]"
    )
    tension_part: Annotated[float, Field(gt=0.0, le=1.0)] = Field(
        0.9,
        description="largest tension at which the target rests, as a fraction of limits.tension_max [-]; the rest is"
        " for motion and loads",
    )
