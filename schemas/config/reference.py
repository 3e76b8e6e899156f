"""[reference]: target or trajectory of the tip."""

from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from tendond.schemas.base import Vector3
from tendond.schemas.config.renamed import BRANCHES
from tendond.schemas.config.spatial import SPACE_KINDS, SpaceKeys

TARGETS = ("position", "across", "angle", "direction")
"""Keys that name a target; exactly one is used."""

SAMPLE_SPACING_MIN = 1e-4
"""Smallest time between two samples [s]: a tenth of the shortest cycle."""


def _present_branch(value: Any) -> Any:
    return BRANCHES.get(value, value) if isinstance(value, str) else value


Time = Annotated[float, Field(ge=0.0, description="time of the sample [s]")]
Sample = tuple[Time, float, float] | tuple[Time, float, float, float]


class ReferenceSection(SpaceKeys):
    """[reference]: a target, samples, or a trajectory in space."""

    position: Vector3 | None = Field(
        None, description="target position of the tip [m]; x (or y) and z are used, depending on the plane"
    )
    across: float | None = Field(None, description="target of x alone (or y) [m]; z follows from the resting shape")
    angle: Annotated[float, Field(ge=-6.3, le=6.3)] | None = Field(
        None, description="target bending angle, of the tip's direction against the straight rod's [rad]"
    )
    direction: Vector3 | None = Field(None, description="target direction of the tip, in the plane [-]")
    branch: Annotated[Literal["above_135", "below_135"] | None, BeforeValidator(_present_branch)] = Field(
        None,
        description="of two resting shapes with the same x (or y, or both), the one bent by more or by less than about"
        " 135 degrees, where the tip turns back; default: above_135 in the plane, below_135 in space",
    )
    unreachable: Literal["refuse", "track"] = Field(
        "refuse",
        description="handling of a target that no resting shape reaches: refuse to start, or track it as well as"
        " possible",
    )
    path: Literal["curve", "direct"] = Field(
        "curve",
        description="path to the target; curve: along the tips of resting shapes; direct: x (or y) from zero, z at"
        " its target at once",
    )
    kind: Literal[
        "exponential", "step", "minimum_jerk", "samples", "point", "line", "circle", "helix", "figure_eight"
    ] = Field(
        "exponential",
        description="trajectory over time; exponential: 1 - exp(-rate t); point, line, circle, helix,"
        " figure_eight: in space",
    )
    rate: Annotated[float, Field(ge=1e-3, le=1000.0, description="rate of the exponential [1/s]")] = 20.0
    duration: Annotated[float, Field(ge=1e-3, le=3600.0)] = Field(
        1.0, description="duration of the minimum-jerk trajectory, and of the approach to a trajectory in space [s]"
    )
    file: str = Field(
        "",
        description="CSV file of samples, relative to this file, with a header line: time [s], x (or y) [m], z"
        " [m], or x, y, z",
    )
    samples: tuple[Sample, ...] = Field(
        (), description="samples of time [s] and x (or y), z, or x, y, z; filled from 'file'"
    )

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
            if (times and times[0] != 0.0) or any(late - early < SAMPLE_SPACING_MIN for early, late in pairwise(times)):
                raise ValueError(
                    f"the samples' times must start at 0 and increase, by {SAMPLE_SPACING_MIN:g} s or more"
                )
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
        """True for a trajectory in space, false for one in the bending plane."""
        return self.kind in SPACE_KINDS or (bool(self.samples) and len(self.samples[0]) == 4)

    @property
    def target_name(self) -> str:
        """Name of the target in use, of `TARGETS`; default: `across`, the paper's 0.34 m."""
        return next((name for name in TARGETS if getattr(self, name) is not None), "across")
