"""[rod]: geometry, material, damping and tendons of the robot."""

from typing import Annotated, Literal

from pydantic import Field

from tendond.schemas import paper_robot
from tendond.schemas.base import Schema, Vector3
from tendond.schemas.config.ranges import NotNegative, Positive

Diagonal = tuple[NotNegative, NotNegative, NotNegative]


class RodSection(Schema):
    """[rod] and [simulator.rod]: parameters of the Cosserat rod; the defaults are the paper's robot."""

    length: Annotated[float, Field(gt=0.0, le=10.0, description="length of the backbone [m]")] = paper_robot.LENGTH
    radius: Annotated[float, Field(gt=0.0, le=0.1, description="radius of the backbone [m]")] = paper_robot.RADIUS
    youngs_modulus: Annotated[float, Field(ge=1e6, le=1e12, description="Young's modulus of the backbone [Pa]")] = (
        paper_robot.YOUNGS_MODULUS
    )
    poisson_ratio: Annotated[float, Field(ge=0.0, le=0.5, description="Poisson's ratio of the backbone [-]")] = (
        paper_robot.POISSON_RATIO
    )
    density: Annotated[
        float, Field(gt=0.0, le=1e6, description="density of the backbone with disks, glue and markers [kg/m^3]")
    ] = paper_robot.DENSITY
    shear_damping: Diagonal = Field(
        paper_robot.SHEAR_DAMPING, description="damping of shear and extension, diagonal of Bse [N s]"
    )
    bending_damping: Diagonal = Field(
        paper_robot.BENDING_DAMPING, description="damping of bending and torsion, diagonal of Bbt [N m^2 s]"
    )
    drag: Diagonal = Field(paper_robot.DRAG, description="drag of the air, diagonal of C [kg/m^2]")
    gravity: Vector3 = Field(
        paper_robot.GRAVITY, description="gravity in the world frame, with the straight rod along +z [m/s^2]"
    )
    tendon_positions: Annotated[
        tuple[tuple[float, float], ...],
        Field(min_length=1, max_length=16, description="position (x, y) of each tendon in the cross-section [m]"),
    ] = paper_robot.TENDON_POSITIONS
    tip_mass: Annotated[float, Field(ge=0.0, le=10.0, description="mass of a tool or marker body on the tip [kg]")] = (
        0.0
    )
    tip_inertia: Diagonal = Field(
        (0.0, 0.0, 0.0), description="inertia of that body about its centre of mass, diagonal, body frame [kg m^2]"
    )
    tip_offset: Vector3 = Field(
        (0.0, 0.0, 0.0), description="centre of mass of that body, from the tip, body frame [m]"
    )
    tendon_stiffness: Positive | None = Field(
        None, description="stiffness of a whole tendon [N/m]; default: inextensible"
    )
    space: Literal["euler", "rk4", "rk6"] = Field(
        "rk6", description="integration scheme along the rod; euler is the paper's"
    )
    nodes: (
        Annotated[
            int,
            Field(
                ge=2,
                le=2000,
                description="number of nodes along the rod; default: the scheme's own",
            ),
        ]
        | None
    ) = None
    alpha: Annotated[float, Field(ge=-0.5, le=0.0, description="parameter of the BDF-alpha scheme in time [-]")] = -0.2
