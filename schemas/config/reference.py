"""[reference]: where the tip is to go once it tracks, and how it gets there."""

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, model_validator

from tendond.schemas.base import Vector3
from tendond.schemas.config.spatial import SPACE_KINDS, SpaceKeys

TARGETS = ("position", "across", "angle", "direction")
"""Ways to name a target; exactly one is used."""

CLOSEST = 1e-4
"""[s] Between two samples: the shortest cycle takes ten times as long."""

Time = Annotated[float, Field(ge=0.0, description="[s]")]
Sample = tuple[Time, float, float] | tuple[Time, float, float, float]


class ReferenceSection(SpaceKeys):
    """[reference]: one target, or samples, or a course in space; and the way there."""

    position: Vector3 | None = Field(None, description="target of the tip [m]; x (or y) and z count, by the plane")
    across: float | None = Field(None, description="target of x alone (or y) [m]; z is what the shape makes of it")
    angle: Annotated[float, Field(ge=-6.3, le=6.3)] | None = Field(
        None, description="target of the bending angle: tip's direction against the straight rod's [rad]"
    )
    direction: Vector3 | None = Field(None, description="target of the tip's direction, in the plane [-]")
    branch: Literal["far", "near"] | None = Field(
        None,
        description="of two shapes with the same x (or y, or both): the one bent further, or the other; "
        "left out: far in the plane, near in space",
    )
    unreachable: Literal["refuse", "track"] = Field(
        "refuse", description="a target that no shape has: refuse to start, or track it as well as can be"
    )
    path: Literal["curve", "direct"] = Field(
        "curve",
        description="curve: along the tips of resting shapes; direct: x (or y) from zero, z at its target at once",
    )
    kind: Literal[
        "exponential", "step", "minimum_jerk", "samples", "point", "line", "circle", "helix", "figure_eight"
    ] = Field("exponential", description="course in time; exponential: 1 - exp(-rate t); from 'point' on: in space")
    rate: Annotated[float, Field(ge=1e-3, le=1000.0, description="of the exponential [1/s]")] = 20.0
    duration: Annotated[float, Field(ge=1e-3, le=3600.0)] = Field(
        1.0, description="of the minimum-jerk course, and of the way to a course in space [s]"
    )
    file: str = Field(
        "", description="CSV of samples beside this file: time [s], x (or y) [m], z [m], or x, y, z; with a heading"
    )
    samples: tuple[Sample, ...] = Field((), description="time [s], x (or y), z, or x, y, z [m]: 'file' as it is read")

    @model_validator(mode="after")
    def _one_target(self) -> "ReferenceSection":
        given = [name for name in TARGETS if getattr(self, name) is not None]
        if self.kind == "samples":
            if given:
                raise ValueError(f"kind = 'samples' has no target: leave out {', '.join(given)}")
            if len(self.samples) < 2 and not (self.file and not self.samples):
                raise ValueError("kind = 'samples' needs a file, or two samples or more")
            if len({len(sample) for sample in self.samples}) > 1:
                raise ValueError("the samples must all have three numbers, or all four")
            times = [sample[0] for sample in self.samples]
            if (times and times[0] != 0.0) or any(late - early < CLOSEST for early, late in pairwise(times)):
                raise ValueError(f"the samples' times must start at 0 and increase, by {CLOSEST:g} s or more")
        elif self.kind == "point" and given not in (["position"], ["direction"]):
            raise ValueError("kind = 'point' needs a position or a direction")
        elif self.kind in SPACE_KINDS[1:] and given:
            raise ValueError(f"kind = '{self.kind}' has no target: leave out {', '.join(given)}")
        elif len(given) > 1:
            raise ValueError(f"give one target, not {' and '.join(given)}")
        elif self.samples or self.file:
            raise ValueError("samples and file go with kind = 'samples'")
        if self.kind == "line" and len(self.start) != len(self.end):
            raise ValueError("start and end of a line must both have two numbers, or both three")
        return self

    @property
    def in_space(self) -> bool:
        """Whether it is for a law that moves the tip in space; the others are in the bending plane."""
        return self.kind in SPACE_KINDS or (bool(self.samples) and len(self.samples[0]) == 4)

    @property
    def target_name(self) -> str:
        """Which of `TARGETS` is used; without any, `across`, whose default is the paper's 0.34 m."""
        return next((name for name in TARGETS if getattr(self, name) is not None), "across")
