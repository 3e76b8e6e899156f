"""[commissioning], [pretension]: checks before the first pull, and the tensions before tracking."""

from typing import Annotated

from pydantic import Field

from tendond.schemas.base import Schema
from tendond.schemas.config.ranges import NotNegative, Positive


class CommissioningSection(Schema):
    """[commissioning]: checks between the request to arm and the first pull."""

    rest: bool = Field(True, description="compare the measured tip at rest with the model's before arming")
    probe: bool = Field(
        True, description="pull each tendon a little at the first arming and compare the tip's motion with the model's"
    )
    weight_max: Positive | None = Field(
        None,
        description="largest unknown weight on the tip [kg]; default: 1.2 times the rod's own mass plus EI/(L^2 g)",
    )
    stiffness: Annotated[float, Field(ge=0.0, le=0.8)] = Field(
        0.25, description="largest relative difference of Young's modulus from rod.youngs_modulus [-]"
    )
    tilt: Annotated[float, Field(gt=0.0, le=0.5)] = Field(
        0.035, description="largest tilt of the base against the camera's frame [rad]"
    )
    offset: Annotated[float, Field(gt=0.0, le=0.5)] = Field(
        0.005, description="largest offset of the base, as a fraction of the rod's length [-]"
    )
    orientation: Annotated[float, Field(gt=0.0, le=3.2)] = Field(
        0.0175,
        description="largest rotation of the tip's markers against the tip [rad]; 3.2: their axes are ignored",
    )
    motion: Annotated[float, Field(gt=0.0, le=0.05)] = Field(
        0.02, description="tip motion that the probe of a tendon aims at, as a fraction of the rod's length [-]"
    )
    tension_fraction: Annotated[float, Field(gt=0.0, le=0.2)] = Field(
        0.1, description="largest tension of the probe, as a fraction of limits.tension_max [-]"
    )
    ramp: Annotated[float, Field(gt=0.0, le=5.0)] = Field(0.2, description="duration of the probe's tension ramp [s]")
    settling: Annotated[float, Field(gt=0.0, le=20.0)] = Field(
        2.0, description="time for the tip to settle after a ramp [s]"
    )
    angle: Annotated[float, Field(gt=0.0, le=1.5)] = Field(
        0.6, description="largest angle between measured and expected motion [rad]"
    )
    gain_min: Annotated[float, Field(gt=0.0, lt=1.0)] = Field(
        0.62, description="smallest ratio of measured to expected motion [-]"
    )
    gain_max: Annotated[float, Field(gt=1.0, le=3.0)] = Field(
        1.5, description="largest ratio of measured to expected motion [-]"
    )


class PretensionSection(Schema):
    """[pretension]: tensions between arming and tracking, and the lower bounds while tracking."""

    tension: NotNegative = Field(
        0.5, description="tension of the agonist before tracking begins [N]; the laws need a bent rod"
    )
    antagonist: NotNegative = Field(
        0.0, description="smallest tension of agonist and antagonist while the law pulls, where there are both [N]"
    )
    tension_min: NotNegative = Field(
        1.0, description="smallest tension of every tendon under a law that moves the tip in space [N]"
    )
    duration: Annotated[float, Field(ge=0.0, le=60.0, description="duration of the pretension ramp [s]")] = 0.2
