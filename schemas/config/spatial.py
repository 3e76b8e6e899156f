"""[reference]: the keys of courses in space, which the law 'sensitivity' follows; docs/space.md tells of them."""

from typing import Annotated, Literal

from pydantic import Field

from tendond.schemas.base import Schema

SPACE_KINDS = ("point", "line", "circle", "helix", "figure_eight")
"""Kinds of [reference] that are in space; 'samples' is too where they have four columns."""

Place = Annotated[tuple[float, ...], Field(min_length=2, max_length=3)]
"""x, y [m], and z or else what the resting shape makes of it; with aim 'direction' the tilt towards x, y [rad]."""


class SpaceKeys(Schema):
    """Of [reference]."""

    aim: Literal["position", "direction"] = Field(
        "position",
        description="what a course in space is of: the tip's place [m]; or its direction, as the tilt towards x and y, "
        "whose size is the angle to the straight rod [rad]",
    )
    start: Place = Field((-0.2, 0.0), description="of a line: x, y [m], or z too; see aim")
    end: Place = Field((0.2, 0.0), description="of a line, from where it goes back")
    center: Place = Field((0.0, 0.0), description="of circle, helix, figure-eight: x, y [m], or z too; see aim")
    radius: Annotated[float, Field(gt=0.0, le=10.0)] = Field(
        0.25, description="of circle, helix (its first), half the width of a figure-eight [m]; see aim"
    )
    radius_end: Annotated[float, Field(gt=0.0, le=10.0)] = Field(
        0.1, description="of a helix, its last [m]; its height is what the shape makes of it"
    )
    period: Annotated[float, Field(ge=1e-3, le=3600.0, description="of a turn, or of a line there and back [s]")] = 4.0
    laps: Annotated[int, Field(ge=1, le=1000, description="turns")] = 2
    moved_max: Annotated[float, Field(ge=0.0, le=10.0)] = Field(
        0.02, description="by which a course may be moved to where the tip can rest; one that needs more is refused [m]"
    )
