"""Foxglove's well-known messages, as far as tendond writes them: viewers know what to draw by their schemas' names.

Class and field names are Foxglove's (docs.foxglove.dev, message schemas). SI units; every position is in the frame of
the robot's base.
"""

from collections.abc import Sequence
from enum import IntEnum
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, Field

from tendond.schemas import base

FRAME = "base"
"""Frame of every pose and shape: origin at the clamped end, the straight rod along +z."""

ROD = "rod"
"""Identifier of the rod's scene entity."""

TRAIL = "trail"
"""Identifier of the entity that shows where the tip has been."""

TRAIL_POINTS = 60
"""Points of the trail, one for each shape: three seconds with the default configuration."""

TICK = "tick"
"""Key of the cycle's index in the metadata of the rod's scene entity."""

_ROD_THICKNESS = 0.004  # [m] drawn: twice the backbone's diameter, to be seen
_MARKER = 0.012  # [m] diameter of the spheres at tip and target
_SHAPE_POINTS = 50  # a shape is for the eye: this many points, to the micrometre, are a smooth curve in 2 kB,
_TENDON_POINTS = 10
_TENDON_THICKNESS = 0.001  # [m]
_TRAIL_THICKNESS = 0.0015  # [m]
_TRAIL_DECIMALS = 4
_SHAPE_DECIMALS = 6  # and building them takes the control loop 0.1 ms; 200 points take 0.5 ms

_Nanoseconds = Annotated[int, Field(ge=0, lt=1_000_000_000)]
_Natural = Annotated[int, Field(ge=0)]


class WellKnown(base.Schema):
    """A type that Foxglove knows by its name, `foxglove.` and the class's."""

    model_config = ConfigDict(model_title_generator=lambda model: f"foxglove.{model.__name__}")


class Time(WellKnown):
    """A point in time: whole seconds and nanoseconds."""

    model_config = ConfigDict(title="time")
    sec: _Natural
    nsec: _Nanoseconds


class Duration(WellKnown):
    """A length of time; zero as the lifetime of an entity is for ever."""

    model_config = ConfigDict(title="duration")
    sec: int = 0
    nsec: _Nanoseconds = 0


class Vector3(WellKnown):
    """Position or size [m]."""

    x: float
    y: float
    z: float


class Point3(WellKnown):
    """Position [m]."""

    x: float
    y: float
    z: float


class Quaternion(WellKnown):
    """Unit quaternion, body to frame."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    w: float = 1.0


class Pose(WellKnown):
    """Position [m] and orientation."""

    position: Vector3 = Vector3(x=0.0, y=0.0, z=0.0)
    orientation: Quaternion = Quaternion()


class PoseInFrame(WellKnown):
    """A pose with its time and frame."""

    timestamp: Time
    frame_id: str = FRAME
    pose: Pose


class FrameTransform(WellKnown):
    """Pose of a frame in another one: position [m] and orientation."""

    timestamp: Time
    parent_frame_id: str = FRAME
    child_frame_id: str
    translation: Vector3
    rotation: Quaternion


class FrameTransforms(WellKnown):
    """Frames, all at once."""

    transforms: tuple[FrameTransform, ...]


class LogLevel(IntEnum):
    """Level of a log line."""

    UNKNOWN = 0
    DEBUG = 1
    INFO = 2
    WARNING = 3
    ERROR = 4
    FATAL = 5


class Log(WellKnown):
    """A log line: name is the process's, file and line are where it was written."""

    timestamp: Time
    level: LogLevel
    message: str
    name: str = "tendond"
    file: str = ""
    line: _Natural = 0


class Color(WellKnown):
    """Red, green, blue, alpha, 0 to 1."""

    r: float
    g: float
    b: float
    a: float = 1.0


class KeyValuePair(WellKnown):
    """Key and value in an entity's metadata."""

    key: str
    value: str


class SpherePrimitive(WellKnown):
    """A sphere; size: diameters [m]."""

    pose: Pose
    size: Vector3
    color: Color


class LineType(IntEnum):
    """Manner in which points are joined."""

    LINE_STRIP = 0
    LINE_LOOP = 1
    LINE_LIST = 2


class LinePrimitive(WellKnown):
    """A line through points [m]; thickness [m], or pixels where scale_invariant."""

    type: LineType = LineType.LINE_STRIP
    pose: Pose = Pose()
    thickness: float
    scale_invariant: bool = False
    points: tuple[Point3, ...]
    color: Color
    colors: tuple[Color, ...] = ()
    indices: tuple[_Natural, ...] = ()


class Unused(WellKnown):
    """A primitive that tendond does not draw; its list must be there, empty."""


class SceneEntity(WellKnown):
    """Things to draw; replaces the entity of the same id."""

    timestamp: Time
    frame_id: str = FRAME
    id: str
    lifetime: Duration = Duration()
    frame_locked: bool = True
    metadata: tuple[KeyValuePair, ...] = ()
    arrows: tuple[Unused, ...] = ()
    cubes: tuple[Unused, ...] = ()
    spheres: tuple[SpherePrimitive, ...] = ()
    cylinders: tuple[Unused, ...] = ()
    lines: tuple[LinePrimitive, ...] = ()
    triangles: tuple[Unused, ...] = ()
    texts: tuple[Unused, ...] = ()
    models: tuple[Unused, ...] = ()


class SceneUpdate(WellKnown):
    """Entities to add or replace."""

    deletions: tuple[Unused, ...] = ()
    entities: tuple[SceneEntity, ...]


def timestamp(time_ns: int) -> Time:
    """Nanoseconds as Foxglove's time."""
    sec, nsec = divmod(time_ns, 1_000_000_000)
    return Time(sec=sec, nsec=nsec)


def log_line(time_ns: int, level: LogLevel, message: str, name: str = "tendond") -> Log:
    """A log line of process `name` at `time_ns` [ns]."""
    return Log(timestamp=timestamp(time_ns), level=level, message=message, name=name)


def pose_in_frame(time_ns: int, position: base.Vector3, orientation: base.Quaternion) -> PoseInFrame:
    """A pose at `time_ns` [ns]: position [m] in the base's frame, orientation w, x, y, z."""
    w, x, y, z = orientation
    return PoseInFrame(
        timestamp=timestamp(time_ns),
        pose=Pose(position=_vector(position), orientation=Quaternion(x=x, y=y, z=z, w=w)),
    )


def frame_transforms(time_ns: int, frames: dict[str, tuple[base.Vector3, base.Quaternion]]) -> FrameTransforms:
    """Frames by name in the base's frame: position [m], orientation w, x, y, z."""
    poses = {name: pose_in_frame(time_ns, *place) for name, place in frames.items()}
    return FrameTransforms(
        transforms=tuple(
            FrameTransform(
                timestamp=stamped.timestamp,
                child_frame_id=name,
                translation=stamped.pose.position,
                rotation=stamped.pose.orientation,
            )
            for name, stamped in poses.items()
        )
    )


def tendon_paths(
    rotations: NDArray[np.float64], points: NDArray[np.float64], holes: Sequence[tuple[float, float]]
) -> list[NDArray[np.float64]]:
    """The tendons beside the backbone, for the eye: a few points each [m], shape (k, 3).

    Args:
        rotations: rotations of the rod's nodes, equally spaced, body to world, shape (nodes, 3, 3).
        points: points of the backbone, equally spaced [m], shape (p, 3).
        holes: (x, y) of each tendon in the cross-section [m].
    """
    kept = np.linspace(0, len(points) - 1, min(len(points), _TENDON_POINTS)).round().astype(np.intp)
    at = kept / (len(points) - 1) * (len(rotations) - 1)
    nodes = np.arange(len(rotations))
    paths = []
    for x, y in holes:
        arms = rotations[:, :, 0] * x + rotations[:, :, 1] * y
        paths.append(points[kept] + np.stack([np.interp(at, nodes, arms[:, i]) for i in range(3)], axis=1))
    return paths


def rod_shape(
    time_ns: int,
    tick: int,
    points: NDArray[np.float64],
    target: base.Vector3,
    tendons: Sequence[NDArray[np.float64]] = (),
    trail: Sequence[base.Vector3] = (),
) -> SceneUpdate:
    """The rod, its tendons, its tip and the target as one entity, the rod its first line; the tip's trail as another.

    Args:
        time_ns: time of the shape [ns].
        tick: index of the cycle.
        points: points of the backbone, base to tip [m], shape (nodes, 3); at most 50 are kept, the ends among them.
        target: where the tip should be [m].
        tendons: see `tendon_paths`.
        trail: where the tip has been, at most `TRAIL_POINTS` [m].
    """
    kept = np.linspace(0, len(points) - 1, min(len(points), _SHAPE_POINTS)).round().astype(np.intp)
    rounded: list[list[float]] = np.round(points[kept], _SHAPE_DECIMALS).tolist()
    steel, orange = Color(r=0.25, g=0.45, b=0.7), Color(r=0.9, g=0.45, b=0.1)
    rod = _line(rounded, _ROD_THICKNESS, steel)
    strings = [
        _line(np.round(path, _SHAPE_DECIMALS).tolist(), _TENDON_THICKNESS, Color(r=0.5, g=0.5, b=0.5))
        for path in tendons
    ]
    return SceneUpdate(
        entities=(
            SceneEntity(
                timestamp=timestamp(time_ns),
                id=ROD,
                metadata=(KeyValuePair(key=TICK, value=str(tick)),),
                lines=(rod, *strings),
                spheres=(_sphere(rounded[-1], steel), _sphere(target, orange)),
            ),
            SceneEntity(timestamp=timestamp(time_ns), id=TRAIL, lines=(_trail(trail),)),
        )
    )


def _trail(points: Sequence[base.Vector3]) -> LinePrimitive:
    rounded = np.round(np.reshape(points, (-1, 3)), _TRAIL_DECIMALS).tolist()
    return _line(rounded, _TRAIL_THICKNESS, Color(r=0.25, g=0.45, b=0.7, a=0.6))


def _line(points: Sequence[Sequence[float]], thickness: float, color: Color) -> LinePrimitive:
    return LinePrimitive(thickness=thickness, points=tuple(Point3(x=x, y=y, z=z) for x, y, z in points), color=color)


def _vector(values: Sequence[float]) -> Vector3:
    x, y, z = values
    return Vector3(x=x, y=y, z=z)


def _sphere(centre: Sequence[float], color: Color) -> SpherePrimitive:
    return SpherePrimitive(pose=Pose(position=_vector(centre)), size=_vector((_MARKER,) * 3), color=color)
