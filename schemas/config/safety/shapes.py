"""[safety.tip_region] and [[safety.obstacle]]: simple bodies in the base's frame."""

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from tendond.schemas.base import Schema, Vector3
from tendond.schemas.config.ranges import Positive

NORMAL_MIN = 1e-6
"""Smallest norm of a normal that has a direction [-]; it is scaled to one."""

Name = Annotated[str, Field(max_length=40, pattern=r"^[^\x00-\x1f\x7f]*$")]


class _Shape(Schema):
    """Keys of a sphere and of a half-space, which regions and obstacles share."""

    center: Vector3 | None = Field(None, description="center of a sphere [m]")
    radius: Positive | None = Field(None, description="radius of a sphere [m]")
    point: Vector3 | None = Field(None, description="a point on the plane of a half_space [m]")
    normal: Vector3 | None = Field(
        None, description="normal of the plane of a half_space, of any length [-]; the robot stays on its side"
    )

    def _misfits(self, kind: str, needed: Mapping[str, tuple[str, ...]]) -> Iterator[str]:
        """Find keys that the kind needs and has not, or has and does not need."""
        keys = {key for names in needed.values() for key in names}
        for key in sorted(keys):
            given = getattr(self, key) is not None
            if key in needed[kind] and not given:
                yield f"{key}: is missing: kind = '{kind}' needs {' and '.join(needed[kind])}"
            elif given and key not in needed[kind]:
                yield f"{key}: kind = '{kind}' has none: remove it"
        if self.normal is not None and math.hypot(*self.normal) < NORMAL_MIN:
            yield "normal: must not be zero: it points to the side on which the robot stays"


class TipRegion(_Shape):
    """[safety.tip_region]: the tip stays inside it."""

    kind: Literal["box", "sphere", "half_space"] = Field(
        description="its shape; box: low and high; sphere: center and radius; half_space: point and normal"
    )
    low: Vector3 | None = Field(None, description="smallest x, y, z of a box [m]")
    high: Vector3 | None = Field(None, description="largest x, y, z of a box [m]")

    @model_validator(mode="after")
    def _fits_its_kind(self) -> Self:
        needed = {"box": ("low", "high"), "sphere": ("center", "radius"), "half_space": ("point", "normal")}
        wrong = list(self._misfits(self.kind, needed))
        if self.low is not None and self.high is not None:
            wrong += [
                f"high: {axis} = {high:g} m must be above low, {low:g} m: the region is empty"
                for axis, low, high in zip("xyz", self.low, self.high, strict=True)
                if high <= low
            ]
        if wrong:
            raise ValueError("\n".join(wrong))
        return self


class Obstacle(_Shape):
    """[[safety.obstacle]]: the whole body stays outside of it."""

    name: Name = Field("", description="its name in messages; default: its number, from 1")
    kind: Literal["sphere", "half_space"] = Field(
        description="its shape; sphere: center and radius; half_space: point and normal, which points to the free side"
    )

    @model_validator(mode="after")
    def _fits_its_kind(self) -> Self:
        needed = {"sphere": ("center", "radius"), "half_space": ("point", "normal")}
        if wrong := list(self._misfits(self.kind, needed)):
            raise ValueError("\n".join(wrong))
        return self
