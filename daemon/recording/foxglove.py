"""Foxglove's well-known messages, as far as tendond writes them: viewers know what to draw by their schemas' names.

Class and field names are Foxglove's (docs.foxglove.dev, message schemas). SI units; every position is in the frame of
the robot's base.
"""

from collections.abc import Sequence
from enum import IntEnum
from typing import Annotated

from pydantic import ConfigDict, Field

from tendond.schemas import base

FRAME = "base"
"""Frame of every pose and shape: origin at the clamped end, the straight rod along +z."""

_Nanoseconds = Annotated[int, Field(ge=0, lt=1_000_000_000)]
Natural = Annotated[int, Field(ge=0)]


class WellKnown(base.Schema):
    """A type that Foxglove knows by its name, `foxglove.` and the class's."""

    model_config = ConfigDict(model_title_generator=lambda model: f"foxglove.{model.__name__}")


class Time(WellKnown):
    """A point in time: whole seconds and nanoseconds."""

    model_config = ConfigDict(title="time")
    sec: Natural
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
    line: Natural = 0


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
        pose=Pose(position=vector(position), orientation=Quaternion(x=x, y=y, z=z, w=w)),
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


def vector(values: Sequence[float]) -> Vector3:
    """Convert x, y, z [m] to Foxglove's vector."""
    x, y, z = values
    return Vector3(x=x, y=y, z=z)
