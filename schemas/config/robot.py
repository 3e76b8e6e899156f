"""[rod]: the robot, and what damps it."""

from typing import Annotated, Literal

from pydantic import Field

from tendond.schemas.base import Schema, Vector3
from tendond.schemas.config.ranges import NotNegative, Positive

Diagonal = tuple[NotNegative, NotNegative, NotNegative]


class RodSection(Schema):
    """[rod] and [simulator.rod]: parameters of the Cosserat rod; the defaults are the paper's robot."""

    length: Annotated[float, Field(gt=0.0, le=10.0, description="[m]")] = 0.5
    radius: Annotated[float, Field(gt=0.0, le=0.1, description="of the backbone [m]")] = 1e-3
    youngs_modulus: Annotated[float, Field(ge=1e6, le=1e12, description="[Pa]")] = 190e9
    poisson_ratio: Annotated[float, Field(ge=0.0, le=0.5, description="[-]")] = 0.3
    density: Annotated[float, Field(gt=0.0, le=1e6, description="with disks, glue, markers [kg/m^3]")] = 17189.0
    shear_damping: Diagonal = Field((0.0, 0.0, 0.0), description="diagonal of Bse [N s]")
    bending_damping: Diagonal = Field((0.008, 0.008, 0.008), description="diagonal of Bbt [N m^2 s]")
    drag: Diagonal = Field((0.1, 0.1, 0.1), description="diagonal of C [kg/m^2]")
    gravity: Vector3 = Field((-9.81, 0.0, 0.0), description="world frame, straight rod along +z [m/s^2]")
    tendon_positions: Annotated[
        tuple[tuple[float, float], ...],
        Field(min_length=1, max_length=16, description="(x, y) of each tendon in the cross-section [m]"),
    ] = ((0.02, 0.0), (0.0, 0.02), (-0.02, 0.0), (0.0, -0.02))
    tip_mass: Annotated[float, Field(ge=0.0, le=10.0, description="of a tool or marker body on the tip [kg]")] = 0.0
    tip_inertia: Diagonal = Field((0.0, 0.0, 0.0), description="diagonal about its centre of mass, body frame [kg m^2]")
    tip_offset: Vector3 = Field((0.0, 0.0, 0.0), description="from the tip to its centre of mass, body frame [m]")
    tendon_stiffness: Positive | None = Field(None, description="[N/m]; left out: tendons do not stretch")
    space: Literal["euler", "rk4", "rk6"] = Field("rk6", description="scheme along the rod; euler is the paper's")
    nodes: (
        Annotated[int, Field(ge=2, le=2000, description="along the rod; left out: the scheme's own number")] | None
    ) = None
    alpha: Annotated[float, Field(ge=-0.5, le=0.0, description="of BDF-alpha [-]")] = -0.2
