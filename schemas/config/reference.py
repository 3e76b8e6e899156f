"""[reference]: target or trajectory of the tip."""

from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from tendond.schemas.base import Quaternion, Schema, Vector3, is_empty
from tendond.schemas.config.ranges import Positive
from tendond.schemas.config.renamed import present_branch

TARGETS = ("position", "across", "angle", "direction")
"""Keys that name a target; exactly one is used."""

SAMPLE_SPACING_MIN = 1e-4
"""Smallest time between two samples [s]: a tenth of the shortest cycle."""


Time = Annotated[float, Field(ge=0.0, description="time of the sample [s]")]
Sample = Annotated[tuple[float, ...], Field(min_length=3, max_length=8)]
"""Time [s], then the columns of the file."""

SAMPLE_WIDTHS, WAYPOINT_WIDTHS = (3, 4, 7, 8), (3, 6, 7)
"""Numbers of a sample, and of a waypoint, which has no time."""

SPACE_KINDS = ("point", "line", "circle", "helix", "figure_eight", "pose", "path")
"""Kinds of [reference] in space; 'samples' with four columns and more are in space too."""

POSE_KINDS = ("pose", "path")
"""Kinds that may prescribe a direction or an orientation beside the position; wide samples do too."""


def _is_none(value: Any) -> bool:
    return value is None


Place = Annotated[tuple[float, ...], Field(min_length=2, max_length=3)]
"""x, y [m] and optionally z, which else follows from the resting shape; with aim 'direction' tilts to x, y [rad]."""


class SpaceKeys(Schema):
    """Keys of [reference] for trajectories in space; docs/space.md describes them."""

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


class PoseKeys(SpaceKeys):
    """Keys of [reference] for poses and paths of robots of sections; docs/howto/sections.md describes them."""

    orientation: Quaternion | None = Field(
        None, description="orientation of a pose: unit quaternion w, x, y, z, body to world", exclude_if=_is_none
    )
    waypoints: tuple[Annotated[tuple[float, ...], Field(min_length=3, max_length=7)], ...] = Field(
        (),
        max_length=2000,
        description="points of a path: x, y, z [m], with a direction or a quaternion w, x, y, z; filled from 'file'",
        exclude_if=is_empty,
    )
    turned_max: Annotated[float, Field(ge=0.0, le=3.2)] = Field(
        0.05, description="largest turn of a pose to where the tip can rest [rad]", exclude_if=lambda one: one == 0.05
    )
    posture: Literal["least_tension", "mid_range"] = Field(
        "least_tension",
        description="use of tendons that a pose leaves free: least tension, or the middle between both limits",
        exclude_if=lambda one: one == "least_tension",
    )
    timing: Literal["given", "optimal"] = Field(
        "given",
        description="timing of a trajectory of poses; given: by duration, period or samples; optimal: as fast as the"
        " limits allow, with bounded jerk",
        exclude_if=lambda one: one == "given",
    )
    speed_max: Positive | None = Field(
        None, description="largest speed of the tip on a trajectory of poses [m/s]", exclude_if=_is_none
    )
    acceleration_max: Positive | None = Field(
        None,
        description="largest acceleration of the tip by component [m/s^2]; default with timing 'optimal': that which"
        " bends the arm by 1 % of its length",
        exclude_if=_is_none,
    )
    jerk_max: Positive | None = Field(
        None,
        description="largest jerk of the tip by component [m/s^3]; default with timing 'optimal': that of averaging"
        " over the period of the first mode",
        exclude_if=_is_none,
    )


class ReferenceSection(PoseKeys):
    """[reference]: a target, samples, or a trajectory in space."""

    position: Vector3 | None = Field(
        None, description="target position of the tip [m]; x (or y) and z are used, depending on the plane"
    )
    across: float | None = Field(None, description="target of x alone (or y) [m]; z follows from the resting shape")
    angle: Annotated[float, Field(ge=-6.3, le=6.3)] | None = Field(
        None, description="target bending angle, of the tip's direction against the straight rod's [rad]"
    )
    direction: Vector3 | None = Field(None, description="target direction of the tip, in the plane [-]")
    branch: Annotated[
        Literal["above_135", "below_135"] | Annotated[int, Field(ge=1, le=99)] | None, BeforeValidator(present_branch)
    ] = Field(
        None,
        description="of the resting shapes with the same x (or y, or both), the most bent (by more than about 135"
        " degrees) or the least, or its number by the bend; default: the least, of the paper's robot above_135",
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
        "exponential",
        "step",
        "minimum_jerk",
        "samples",
        "point",
        "line",
        "circle",
        "helix",
        "figure_eight",
        "pose",
        "path",
    ] = Field(
        "exponential",
        description="trajectory over time; exponential: 1 - exp(-rate t); point, line, circle, helix,"
        " figure_eight: in space; pose, path: in space, with a direction or orientation if given",
    )
    rate: Annotated[float, Field(ge=1e-3, le=1000.0, description="rate of the exponential [1/s]")] = 20.0
    duration: Annotated[float, Field(ge=1e-3, le=3600.0)] = Field(
        1.0, description="duration of the minimum-jerk trajectory, and of the approach to a trajectory in space [s]"
    )
    file: str = Field(
        "",
        description="CSV file of samples, relative to this file, with a header line: time [s], x (or y) [m], z"
        " [m], or x, y, z, or these with a direction or a quaternion w, x, y, z; of a path: without the time",
    )
    samples: tuple[Sample, ...] = Field(
        (), description="samples of time [s] and x (or y), z, or x, y, z, or a pose; filled from 'file'"
    )

    @model_validator(mode="after")
    def _one_target(self) -> "ReferenceSection":
        given = [name for name in TARGETS if getattr(self, name) is not None]
        if self.kind == "samples":
            if given:
                raise ValueError(f"kind = 'samples' has no target: leave out {', '.join(given)}")
            if len(self.samples) < 2 and not (self.file and not self.samples):
                raise ValueError("kind = 'samples' needs a file, or two samples or more")
            widths = {len(sample) for sample in self.samples}
            if len(widths) > 1 or not widths <= set(SAMPLE_WIDTHS):
                raise ValueError(
                    "the samples must all have three numbers, or all four, or with a direction seven, or with a "
                    "quaternion eight"
                )
            if any(sample[0] < 0.0 for sample in self.samples):
                raise ValueError("the samples' times must not be negative")
            times = [sample[0] for sample in self.samples]
            if (times and times[0] != 0.0) or any(late - early < SAMPLE_SPACING_MIN for early, late in pairwise(times)):
                raise ValueError(
                    f"the samples' times must start at 0 and increase, by {SAMPLE_SPACING_MIN:g} s or more"
                )
        elif self.kind in POSE_KINDS:
            _check_pose(self, given)
        elif self.kind == "point" and given not in (["position"], ["direction"]):
            raise ValueError("kind = 'point' needs a position or a direction")
        elif self.kind in SPACE_KINDS[1:] and given:
            raise ValueError(f"kind = '{self.kind}' has no target: leave out {', '.join(given)}")
        elif len(given) > 1:
            raise ValueError(f"give one target, not {' and '.join(given)}")
        elif self.samples or self.file:
            raise ValueError("samples and file go with kind = 'samples'")
        if self.kind not in POSE_KINDS and (self.orientation is not None or self.waypoints):
            raise ValueError("orientation goes with kind = 'pose', waypoints with kind = 'path'")
        if self.in_space and isinstance(self.branch, int):
            raise ValueError("branch is no number in space")
        if self.kind == "line" and len(self.start) != len(self.end):
            raise ValueError("start and end of a line must both have two numbers, or both three")
        return self

    @property
    def in_space(self) -> bool:
        """True for a trajectory in space, false for one in the bending plane."""
        return self.kind in SPACE_KINDS or (bool(self.samples) and len(self.samples[0]) >= 4)

    @property
    def has_poses(self) -> bool:
        """True if a direction or an orientation may be prescribed beside the position."""
        return self.kind in POSE_KINDS or (bool(self.samples) and len(self.samples[0]) > 4)

    @property
    def target_name(self) -> str:
        """Name of the target in use, of `TARGETS`; default: `across`, the paper's 0.34 m."""
        return next((name for name in TARGETS if getattr(self, name) is not None), "across")


def _check_pose(section: ReferenceSection, given: list[str]) -> None:
    """Refuse a pose or a path that is not one.

    Raises:
        ValueError: says what.
    """
    if section.samples:
        raise ValueError("samples go with kind = 'samples'")
    if section.kind == "path":
        widths = {len(point) for point in section.waypoints}
        if given or section.orientation is not None:
            raise ValueError("kind = 'path' has no target: its waypoints are in file or waypoints")
        if len(section.waypoints) < 2 and not (section.file and not section.waypoints):
            raise ValueError("kind = 'path' needs a file, or two waypoints or more")
        if len(widths) > 1 or not widths <= set(WAYPOINT_WIDTHS):
            raise ValueError("the waypoints must all have 3 numbers, or all 6 with a direction, or 7 with a quaternion")
        return
    if section.file or section.waypoints:
        raise ValueError("file and waypoints go with kind = 'path'")
    if given not in (["position"], ["position", "direction"]):
        raise ValueError("kind = 'pose' needs a position, and may have a direction or an orientation")
    if section.orientation is not None and section.direction is not None:
        raise ValueError("orientation includes the direction: give one of them")
    if section.orientation is not None and not 0.99 < sum(one * one for one in section.orientation) < 1.01:
        raise ValueError("orientation must be a unit quaternion w, x, y, z")
