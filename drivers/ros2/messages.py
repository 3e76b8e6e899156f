"""A rig's messages as those of ROS 2: SI units, the rod's base frame, wall-clock stamps.

ROS has quaternions as x, y, z, w, where tendond has w, x, y, z.
"""

import math
from collections.abc import Mapping, Sequence
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.drivers.ros2.names import ros_name
from tendond.drivers.ros2.topics import DIAGNOSTICS, ESTIMATE, JOINTS, MARKERS, POINT, POSE, TEXT, TRANSFORMS
from tendond.drivers.ros2.types import Types
from tendond.schemas.base import Quaternion, Vector3
from tendond.schemas.record import Covariance

Array = NDArray[np.float64]
Place = tuple[Vector3, Quaternion]
"""Position [m] and unit quaternion w, x, y, z, in the frame of the base."""

UNKNOWN_TURN = math.pi**2
"""Variance of an orientation about which nothing is known [rad^2]: half a turn to each side is one deviation."""


class Level(IntEnum):
    """Level of a diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


Health = tuple[Level, str, str, Mapping[str, str]]
"""Level, name, message and further values of a diagnostic_msgs/DiagnosticStatus."""


class RigMessages:
    """Makes the messages of a rig.

    Args:
        types: of the distribution.
        rig: its name, by which the frames are named.

    Attributes:
        types: of the distribution.
        base, tip, model_tip: frames of the rod's base, of the measured and of the model's tip.
    """

    def __init__(self, types: Types, rig: str) -> None:
        name = ros_name(rig)
        self.types = types
        self.rig = rig
        self.base, self.tip, self.model_tip = f"{name}_base", f"{name}_tip", f"{name}_tip_model"

    def pose(self, time_ns: int, place: Place) -> Any:
        """Return a PoseStamped at a wall-clock time [ns]."""
        return self._make(POSE, header=self._header(time_ns), pose=self._pose(place))

    def estimate(self, time_ns: int, place: Place, covariance: Covariance) -> Any:
        """Return a PoseWithCovarianceStamped.

        Args:
            time_ns: wall-clock time [ns].
            place: of the tip.
            covariance: of its position, xx, xy, xz, yy, yz, zz [m^2]; that of its orientation is unknown.
        """
        matrix = np.zeros((6, 6))
        matrix[np.triu_indices(3)] = covariance
        matrix += np.triu(matrix, 1).T
        matrix[range(3, 6), range(3, 6)] = UNKNOWN_TURN
        pose = self._make("geometry_msgs/msg/PoseWithCovariance", pose=self._pose(place), covariance=matrix.ravel())
        return self._make(ESTIMATE, header=self._header(time_ns), pose=pose)

    def point(self, time_ns: int, position: Vector3) -> Any:
        """Return a PointStamped [m]."""
        return self._make(POINT, header=self._header(time_ns), point=self._point(position))

    def joints(self, time_ns: int, displacement: Sequence[float], tension: Sequence[float]) -> Any:
        """Return a JointState: a prismatic joint per tendon, displacement [m] and tension [N], without velocities."""
        return self._make(
            JOINTS,
            header=self._header(time_ns),
            name=[f"tendon_{i}" for i in range(len(displacement))],
            position=np.array(displacement, dtype=np.float64),
            velocity=np.zeros(0),
            effort=np.array(tension, dtype=np.float64),
        )

    def transforms(self, time_ns: int, frames: Mapping[str, Place]) -> Any:
        """Return a TFMessage with the places of frames in that of the base."""
        return self._make(
            TRANSFORMS,
            transforms=[
                self._make(
                    "geometry_msgs/msg/TransformStamped",
                    header=self._header(time_ns),
                    child_frame_id=child,
                    transform=self._make(
                        "geometry_msgs/msg/Transform",
                        translation=self._vector(position),
                        rotation=self._quaternion(orientation),
                    ),
                )
                for child, (position, orientation) in frames.items()
            ],
        )

    def diagnostics(self, time_ns: int, found: Sequence[Health]) -> Any:
        """Return a DiagnosticArray."""
        make = self._make
        return make(
            DIAGNOSTICS,
            header=self._header(time_ns),
            status=[
                make(
                    "diagnostic_msgs/msg/DiagnosticStatus",
                    level=int(level),
                    name=name,
                    message=message,
                    hardware_id=self.rig,
                    values=[make("diagnostic_msgs/msg/KeyValue", key=key, value=text) for key, text in values.items()],
                )
                for level, name, message, values in found
            ],
        )

    def text(self, data: str) -> Any:
        """Return a String."""
        return self._make(TEXT, data=data)

    def markers(self, time_ns: int, rod: Array, tendons: Sequence[Array], target: Vector3) -> Any:
        """Return a MarkerArray: the backbone, each tendon, and the target.

        Args:
            time_ns: wall-clock time [ns].
            rod: points of the backbone, base to tip [m], shape (n, 3).
            tendons: points of each tendon [m], shapes (k, 3).
            target: of the reference [m].
        """
        header = self._header(time_ns)
        lines = [self._line(header, "rod", 0, rod, 0.004, (0.25, 0.45, 0.7))]
        lines += [self._line(header, "tendons", i, path, 0.001, (0.5, 0.5, 0.5)) for i, path in enumerate(tendons)]
        sphere = self._marker(header, "target", 0, 2, (0.012,) * 3, (0.9, 0.45, 0.1), target, [])
        return self._make(MARKERS, markers=[*lines, sphere])

    def _line(
        self, header: Any, name: str, number: int, points: Array, width: float, color: tuple[float, float, float]
    ) -> Any:
        places = [self._point((x, y, z)) for x, y, z in np.asarray(points).tolist()]
        return self._marker(header, name, number, 4, (width, 0.0, 0.0), color, (0.0, 0.0, 0.0), places)

    def _marker(
        self,
        header: Any,
        name: str,
        number: int,
        kind: int,
        scale: tuple[float, ...],
        color: tuple[float, float, float],
        position: Vector3,
        points: list[Any],
    ) -> Any:
        """Return a Marker; `kind` is 2 for a sphere, 4 for a line strip, as visualization_msgs/Marker has them."""
        make, nothing = self._make, np.zeros(0, dtype=np.uint8)
        red, green, blue = color
        width, depth, height = scale
        return make(
            "visualization_msgs/msg/Marker",
            header=header,
            ns=name,
            id=number,
            type=kind,
            action=0,
            pose=self._pose((position, (1.0, 0.0, 0.0, 0.0))),
            scale=self._vector((width, depth, height)),
            color=make("std_msgs/msg/ColorRGBA", r=red, g=green, b=blue, a=1.0),
            lifetime=make("builtin_interfaces/msg/Duration", sec=0, nanosec=0),
            frame_locked=False,
            points=points,
            colors=[],
            texture_resource="",
            texture=make("sensor_msgs/msg/CompressedImage", header=header, format="", data=nothing),
            uv_coordinates=[],
            text="",
            mesh_resource="",
            mesh_file=make("visualization_msgs/msg/MeshFile", filename="", data=nothing),
            mesh_use_embedded_materials=False,
        )

    def _make(self, type_name: str, /, **fields: Any) -> Any:
        return self.types.make(type_name, **fields)

    def _header(self, time_ns: int) -> Any:
        sec, nanosec = divmod(time_ns, 1_000_000_000)
        stamp = self._make("builtin_interfaces/msg/Time", sec=sec, nanosec=nanosec)
        return self._make("std_msgs/msg/Header", stamp=stamp, frame_id=self.base)

    def _pose(self, place: Place) -> Any:
        position, orientation = place
        return self._make(
            "geometry_msgs/msg/Pose", position=self._point(position), orientation=self._quaternion(orientation)
        )

    def _point(self, position: Vector3) -> Any:
        x, y, z = position
        return self._make("geometry_msgs/msg/Point", x=x, y=y, z=z)

    def _vector(self, position: Vector3) -> Any:
        x, y, z = position
        return self._make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)

    def _quaternion(self, orientation: Quaternion) -> Any:
        w, x, y, z = orientation
        return self._make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)
