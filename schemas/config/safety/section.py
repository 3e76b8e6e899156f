"""[safety]: constraints of the robot's body, which a filter keeps whatever the law asks for."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from tendond.schemas.base import Schema, is_empty
from tendond.schemas.config.ranges import NotNegative
from tendond.schemas.config.safety.shapes import Obstacle, TipRegion

Place = Annotated[float, Field(gt=0.0, le=1.0)]


class SafetySection(Schema):
    """[safety]: constraints of tip, body and strain that alter a command before it breaks them.

    It needs the general rod (control.solver), and acts while the tendons are under control: not in the probe, and not
    on a release. Distances are those of the model's body, corrected as the observer corrects its tip.
    """

    margin: NotNegative = Field(
        0.005, description="distance kept from every surface, beside the declared errors below [m]"
    )
    position_error: NotNegative = Field(0.0, description="declared error of the model's body after correction [m]")
    stiffness_error: Annotated[float, Field(ge=0.0, le=1.0)] = Field(
        0.1, description="declared relative error of stiffness and mass: that part of a motion to come is kept free [-]"
    )
    delay_error: Annotated[float, Field(ge=0.0, le=1.0)] = Field(
        0.0, description="time by which a command may act later than the model assumes; times the speed it is kept [s]"
    )
    approach_time: Annotated[float, Field(ge=0.0, le=10.0)] = Field(
        0.1,
        description="time constant with which a distance may shrink: the largest speed of approach is the distance over"
        " it [s]; 0: none",
    )
    strain_max: Annotated[float, Field(gt=0.0, le=10.0)] | None = Field(
        None, description="largest bending strain of the outermost fibre [-]; default: rod.yield_strain, if it is given"
    )
    stations: Annotated[tuple[Place, ...], Field(min_length=1, max_length=32)] = Field(
        (0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0),
        description="places along the body that stay clear of obstacles, as parts of its length [-]; 1: the tip",
    )
    body_radius: NotNegative | None = Field(
        None, description="radius of the body about its backbone [m]; default: that of the outermost tendon"
    )
    hold_time: Annotated[float, Field(gt=0.0, le=10.0)] = Field(
        0.5, description="time without a command that keeps the constraints that is a fault [s]; it is held until then"
    )
    tip_region: TipRegion | None = Field(None, description="region in which the tip stays")
    obstacle: tuple[Obstacle, ...] = Field(
        (), max_length=16, description="bodies that the robot stays out of", exclude_if=is_empty
    )

    @model_validator(mode="after")
    def _names_differ(self) -> Self:
        names = [one.name for one in self.obstacle if one.name]
        if len(set(names)) < len(names):
            raise ValueError("obstacle: two have the same name: give each its own")
        return self

    @property
    def labels(self) -> tuple[str, ...]:
        """Name of each obstacle in messages."""
        return tuple(one.name or f"obstacle {index}" for index, one in enumerate(self.obstacle, start=1))
