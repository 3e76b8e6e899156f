"""[[rod.section]]: one section of the backbone."""

import math
from typing import Annotated

from pydantic import Field, model_validator

from tendond.schemas.base import Schema
from tendond.schemas.config.ranges import NotNegative
from tendond.schemas.config.rod.table import Along, Varies, constant_of, end_of

Triple = tuple[NotNegative, NotNegative, NotNegative]
Positive = Annotated[Along, Varies()]
Radius = Annotated[Along, Varies(high=0.5)]
Pair = Annotated[Along, Varies(2)]
Damping = Annotated[Along, Varies(3, low_allowed=True)]
MATERIAL = {
    "bending_stiffness": ("radius", "youngs_modulus"),
    "torsion_stiffness": ("radius", "youngs_modulus"),
    "axial_stiffness": ("radius", "youngs_modulus"),
    "mass_per_length": ("radius", "density"),
}
"""Properties that may be given, and the keys that they follow from otherwise."""


class BackboneSection(Schema):
    """[[rod.section]]: a section of the backbone, from the base on; wire or tube by radius and material, or stiffness.

    Instead of a number, most keys take a table of rows [s, value], s from the section's base [m]: linear between them.
    """

    length: Annotated[float, Field(gt=0.0, le=10.0, description="length of the section [m]")]
    radius: Radius | None = Field(None, description="outer radius [m]")
    inner_radius: Annotated[Along, Varies(low_allowed=True, high=0.5)] = Field(
        0.0, description="inner radius of a tube [m]; 0: a wire"
    )
    youngs_modulus: Annotated[Along, Varies(high=1e12)] | None = Field(None, description="Young's modulus [Pa]")
    poisson_ratio: Annotated[float, Field(ge=0.0, le=0.5, description="Poisson's ratio [-]")] = 0.3
    density: Annotated[Along, Varies(high=1e6)] | None = Field(None, description="density [kg/m^3]")
    bending_stiffness: Pair | None = Field(
        None, description="EI about x and y [N m^2]; default: of the round wire or tube"
    )
    torsion_stiffness: Positive | None = Field(None, description="GJ [N m^2]; default: of the round wire or tube")
    axial_stiffness: Positive | None = Field(None, description="EA [N]; default: of the wire or tube")
    shear_stiffness: Positive | None = Field(
        None, description="GA with its shear factor [N]; default: rigid, as in a slender rod"
    )
    mass_per_length: Positive | None = Field(
        None, description="mass per length with what is spread along it [kg/m]; default: of the wire or tube"
    )
    polar_inertia: Positive | None = Field(
        None, description="inertia per length about the axis [kg m]; default: of a round section"
    )
    precurvature: Annotated[Along, Varies(3, low=-math.inf, scalar=False)] = Field(
        (0.0, 0.0, 0.0), description="curvature without load about x, y, and twist about z, body frame [1/m]"
    )
    damping_ratio: Annotated[float, Field(ge=0.0, le=2.0)] | None = Field(
        None, description="damping ratio of the robot's first bending mode [-]; default: rod.damping_ratio"
    )
    bending_damping: Damping | None = Field(
        None, description="damping of bending and torsion, diagonal of Bbt [N m^2 s]; instead of damping_ratio"
    )
    shear_damping: Triple = Field((0.0, 0.0, 0.0), description="damping of shear and extension, diagonal of Bse [N s]")
    drag: Damping = Field((0.0, 0.0, 0.0), description="drag of the air, diagonal of C [kg/m^2]")
    disk_number: Annotated[
        int, Field(ge=0, le=1000, description="number of equal disks, evenly spaced, the last one at the section's end")
    ] = 0
    disk_mass: NotNegative = Field(0.0, description="mass of one disk [kg]")
    disk_radius: NotNegative = Field(0.0, description="radius of one disk, for its inertia [m]; 0: disk_inertia")
    disk_thickness: NotNegative = Field(0.0, description="thickness of one disk, for its inertia [m]")
    disk_inertia: Triple = Field(
        (0.0, 0.0, 0.0), description="inertia of one disk about its centre, diagonal, body frame [kg m^2]"
    )

    @model_validator(mode="after")
    def _complete(self) -> "BackboneSection":
        wrong = []
        for name, needed in MATERIAL.items():
            if getattr(self, name) is None and any(getattr(self, one) is None for one in needed):
                wrong.append(f"{name}: is missing: give it, or {' and '.join(needed)}")
        if self.radius is not None and not _hollow(self.radius, self.inner_radius):
            wrong.append("inner_radius: must be below radius")
        if self.damping_ratio is not None and self.bending_damping is not None:
            wrong.append("damping_ratio: is described by bending_damping too: remove one of them")
        if self.disk_number and not self.disk_mass:
            wrong.append(f"disk_mass: is missing: {self.disk_number} disks have one")
        if not self.disk_number and (self.disk_mass or self.disk_radius or any(self.disk_inertia)):
            wrong.append("disk_number: is missing: the other keys of disks have no effect without it")
        if self.disk_radius and any(self.disk_inertia):
            wrong.append("disk_inertia: follows from disk_radius too: remove one of them")
        for name in ("radius", "inner_radius", *MATERIAL, "precurvature", "bending_damping", "drag"):
            value = getattr(self, name)
            if value is not None and (last := end_of(value)) > self.length * (1.0 + 1e-9):
                wrong.append(f"{name}: its last row is at s = {last:g} m, beyond length = {self.length:g} m")
        if wrong:
            raise ValueError("\n".join(wrong))
        return self

    @property
    def one_disk_inertia(self) -> tuple[float, float, float]:
        """Inertia of one disk about its centre [kg m^2], as given or that of a solid cylinder."""
        if not self.disk_radius:
            return self.disk_inertia
        across = self.disk_mass * (3.0 * self.disk_radius**2 + self.disk_thickness**2) / 12.0
        return across, across, 0.5 * self.disk_mass * self.disk_radius**2


def _hollow(outer: Along, inner: Along) -> bool:
    """True if there is a wall everywhere, as far as constants show."""
    constants = constant_of(outer, 1), constant_of(inner, 1)
    return constants[0] is None or constants[1] is None or constants[1][0] < constants[0][0]
