"""[commissioning]: what is asked of a rig before it is trusted to be the one that the configuration describes."""

from typing import Annotated

from pydantic import Field

from tendond.schemas.base import Schema
from tendond.schemas.config.ranges import Positive

Part = Annotated[float, Field(gt=0.0, le=0.5)]


class CommissioningSection(Schema):
    """[commissioning]: checks between the request to arm and the first pull."""

    rest: bool = Field(True, description="compare the measured rest with the model's before arming")
    probe: bool = Field(True, description="pull each tendon a little at the first arming, and compare the tip's motion")
    weight_max: Positive | None = Field(
        None,
        description="of an unknown weight on the tip [kg]; left out: 1.2 times the rod's own mass plus EI/(L^2 g)",
    )
    stiffness: Annotated[float, Field(ge=0.0, le=0.8)] = Field(
        0.25, description="by which Young's modulus may differ from [rod] [-]"
    )
    tilt: Annotated[float, Field(gt=0.0, le=0.5)] = Field(
        0.035, description="of the base against the camera's frame that is borne [rad]"
    )
    offset: Part = Field(0.005, description="of the base, as a part of the rod's length that is borne [-]")
    orientation: Annotated[float, Field(gt=0.0, le=3.2)] = Field(
        0.0175,
        description="of the markers on the tip against the tip that is borne; 3.2: their axes do not count [rad]",
    )
    motion: Annotated[float, Field(gt=0.0, le=0.05)] = Field(
        0.02, description="of the tip that the probe of a tendon asks for, as a part of the rod's length [-]"
    )
    tension_part: Annotated[float, Field(gt=0.0, le=0.2)] = Field(
        0.1, description="of limits.tension_max that the probe never exceeds [-]"
    )
    ramp: Annotated[float, Field(gt=0.0, le=5.0)] = Field(0.2, description="of the probe's tension, up [s]")
    settling: Annotated[float, Field(gt=0.0, le=20.0)] = Field(
        2.0, description="[s]; that the tip is given to settle after a ramp"
    )
    angle: Annotated[float, Field(gt=0.0, le=1.5)] = Field(
        0.6, description="between measured and expected motion that is borne [rad]"
    )
    gain_min: Annotated[float, Field(gt=0.0, lt=1.0)] = Field(
        0.62, description="of the measured to the expected motion, at least [-]"
    )
    gain_max: Annotated[float, Field(gt=1.0, le=3.0)] = Field(1.5, description="of the same, at most [-]")
