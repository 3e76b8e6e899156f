"""[reference]: keys of trajectories in space, which the law 'sensitivity' follows; docs/space.md describes them."""

from typing import Annotated, Literal

from pydantic import Field

from tendond.schemas.base import Schema

SPACE_KINDS = ("point", "line", "circle", "helix", "figure_eight")
"""Kinds of [reference] in space; 'samples' with four columns are in space too."""

Place = Annotated[tuple[float, ...], Field(min_length=2, max_length=3)]
"""x, y [m] and optionally z, which else follows from the resting shape; with aim 'direction' tilts to x, y [rad]."""


class SpaceKeys(Schema):
    """Keys of [reference] for trajectories in space."""

    aim: Literal["position", "direction"] = Field(
        "position",
        description="quantity that a trajectory in space prescribes: the tip's position [m]; or its direction, as"
        " tilts towards x "
        "and y whose norm is the angle to the straight rod [rad]",
    )
    start: Place = Field((-0.2, 0.0), description="start of a line: x, y, optionally z [m]; see aim")
    end: Place = Field((0.2, 0.0), description="end of a line: x, y, optionally z [m]; see aim")
    center: Place = Field(
        (0.0, 0.0), description="centre of circle, helix, figure-eight: x, y, optionally z [m]; see aim"
    )
    radius: Annotated[float, Field(gt=0.0, le=10.0)] = Field(
        0.25, description="radius of a circle, first radius of a helix, half the width of a figure-eight [m]; see aim"
    )
    radius_end: Annotated[float, Field(gt=0.0, le=10.0)] = Field(
        0.1, description="last radius of a helix [m]; its height follows from the resting shapes"
    )
    period: Annotated[
        float, Field(ge=1e-3, le=3600.0, description="period of a turn, or of a line there and back [s]")
    ] = 4.0
    laps: Annotated[int, Field(ge=1, le=1000, description="number of turns")] = 2
    moved_max: Annotated[float, Field(ge=0.0, le=10.0)] = Field(
        0.02, description="largest shift of a trajectory to where the tip can rest [m]; one that needs more is refused"
    )
