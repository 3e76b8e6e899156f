"""[[rod.tendon]]: one tendon, its route along the backbone and where it ends."""

from collections.abc import Iterator, Sequence
from typing import Annotated, Literal

from pydantic import Field, model_validator

from tendond.schemas.base import Schema
from tendond.schemas.config.ranges import Positive
from tendond.schemas.config.rod.table import Along, Varies, end_of, first_of

Point = tuple[float, float]


class RodTendon(Schema):
    """[[rod.tendon]]: a tendon, in the order of the commands; straight, converging, helical or through given points."""

    end: Annotated[float, Field(gt=0.0)] | None = Field(
        None, description="arc length at which it is fixed to the backbone [m]; default: the tip"
    )
    position: Point | None = Field(None, description="(x, y) in the cross-section at the base [m]")
    end_position: Point | None = Field(
        None, description="(x, y) where it ends, for a tendon that converges to it [m]; default: position"
    )
    turns: Annotated[float, Field(ge=-100.0, le=100.0)] | None = Field(
        None, description="turns about the backbone from base to end, positive about +z, for a helical tendon [-]"
    )
    route: Annotated[Along, Varies(2, low=float("-inf"), scalar=False)] | None = Field(
        None, description="rows [s, x, y] of a tendon through given points [m]; instead of position"
    )
    stiffness: Positive | None = Field(
        None, description="stiffness of the whole tendon [N/m]; default: inextensible, driven by tension only"
    )
    friction: Annotated[float, Field(ge=0.0, le=2.0)] | None = Field(
        None, description="coefficient of friction on its guides [-]; default: rod.tendon_friction"
    )
    guides: Literal["route", "disks"] = Field(
        "route",
        description="where it rubs; route: all along it, as in a sheath; disks: in the holes of the base and of the"
        " sections' disks, between which it is straight",
    )

    @model_validator(mode="after")
    def _one_route(self) -> "RodTendon":
        wrong = []
        if (self.position is None) == (self.route is None):
            wrong.append("position: give it, or route: one of the two")
        if self.route is not None and (self.end_position is not None or self.turns is not None):
            wrong.append("route: says where the tendon runs: remove end_position and turns")
        if self.end_position is not None and self.turns is not None:
            wrong.append("end_position: is of a converging tendon, turns of a helical one: remove one, or give a route")
        if self.turns is not None and self.position == (0.0, 0.0):
            wrong.append("turns: have no effect on a tendon on the axis: give its position off the axis")
        if wrong:
            raise ValueError("\n".join(wrong))
        return self

    @property
    def at_base(self) -> Point:
        """(x, y) in the cross-section at the base [m]."""
        if self.position is not None:
            return self.position
        x, y = first_of(self.route or (0.0, 0.0), 2)
        return x, y


def beyond(tendons: Sequence[RodTendon], length: float) -> Iterator[str]:
    """Find tendons that leave a backbone of this length [m]; yield what is wrong with them."""
    for index, tendon in enumerate(tendons):
        if tendon.end is not None and tendon.end > length * (1.0 + 1e-9):
            yield f"tendon[{index}].end: {tendon.end:g} m lies beyond the backbone of {length:g} m"
        if tendon.route is not None and end_of(tendon.route) > length * (1.0 + 1e-9):
            yield f"tendon[{index}].route: its last row lies beyond the backbone of {length:g} m"


def frictions_of(tendons: Sequence[RodTendon], common: float) -> tuple[float, ...]:
    """Return the coefficient of friction of each tendon [-], with the common one where it has none of its own."""
    return tuple(common if one.friction is None else one.friction for one in tendons)
