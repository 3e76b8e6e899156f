"""Pose of the tip in the rod's base frame, from two objects in the world of the cameras. Pure."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.rotation import quaternion
from tendond.schemas.base import Quaternion, Vector3
from tendond.schemas.config.rod.bodies import RodBase
from tendond.schemas.config.vicon import Axes, EulerOrder, ViconSection, axis_vector

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Placement:
    """Placement of an object: position [m], shape (3,), and rotation, object to world, shape (3, 3)."""

    position: Array
    rotation: Array

    def after(self, inner: "Placement") -> "Placement":
        """Transform `inner` from this object's frame to this object's world."""
        return Placement(self.position + self.rotation @ inner.position, self.rotation @ inner.rotation)

    def relative_to(self, other: "Placement") -> "Placement":
        """Return this object in the frame of `other`, both given in the same world."""
        return Placement(other.rotation.T @ (self.position - other.position), other.rotation.T @ self.rotation)


WORLD = Placement(np.zeros(3), np.eye(3))


def placed(base: RodBase | None) -> Placement:
    """Return the pose of the base in the world as [rod.base] has it."""
    if base is None:
        return WORLD
    return Placement(np.array(base.position), rotation_from_quaternion(*base.orientation))


def rotation_from_euler(angles: Vector3, order: EulerOrder) -> Array:
    """Rotation matrix, object to world, shape (3, 3).

    Args:
        angles: about the object's x, y and z axis [rad], as Tracker sends them: in this order whatever `order` is.
        order: in which they are applied; capitals: about the axes moved by those before; small: about fixed axes.
    """
    matrix = np.eye(3)
    for letter in order if order.isupper() else reversed(order):
        matrix = matrix @ _about("XYZ".index(letter.upper()), angles["XYZ".index(letter.upper())])
    return matrix


def _about(axis: int, angle: float) -> Array:
    cosine, sine = math.cos(angle), math.sin(angle)
    matrix = np.eye(3)
    j, k = (axis + 1) % 3, (axis + 2) % 3
    matrix[j, j] = matrix[k, k] = cosine
    matrix[j, k], matrix[k, j] = -sine, sine
    return matrix


def rotation_from_quaternion(w: float, x: float, y: float, z: float) -> Array:
    """Rotation matrix of a quaternion that is nearly a unit one, shape (3, 3).

    Raises:
        ValueError: it is none.
    """
    norm = math.sqrt(w * w + x * x + y * y + z * z)
    if not 0.99 < norm < 1.01:
        raise ValueError("no unit quaternion")
    w, x, y, z = w / norm, x / norm, y / norm, z / norm
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def axes_matrix(axes: Axes) -> Array:
    """Columns: the rod frame's x, y and z in the object's frame, shape (3, 3)."""
    return np.array([axis_vector(axis) for axis in axes], dtype=np.float64).T


class Alignment:
    """Alignment of the two objects with the rod.

    Attributes:
        key: name of the section, for messages.

    Args:
        section: [mocap] or [vicon].
        gravity: gravity of the model, in the base frame [m/s^2].
    """

    def __init__(self, section: ViconSection, gravity: Vector3) -> None:
        self.key = section.key
        self._base = Placement(np.array(section.base_offset), axes_matrix(section.base_axes))
        self._tip = Placement(np.array(section.tip_offset), axes_matrix(section.tip_axes))
        self._down = -np.array(axis_vector(section.up), dtype=np.float64)
        norm = math.hypot(*gravity)
        self._gravity = np.array(gravity) / norm if norm > 0.0 and section.knows_up else None

    def tip_in_base(self, tip: Placement, base: Placement) -> Placement:
        """Return the rod's tip in the rod's base frame, from the two objects in their world."""
        return tip.after(self._tip).relative_to(base.after(self._base))

    def gravity_error(self, base: Placement) -> float:
        """Angle between the model's gravity and the measured one [rad]; 0 without gravity or a known direction up."""
        return self.gravity_angle(self.down(base))

    def down(self, base: Placement) -> Array:
        """Unit vector along gravity in the rod's base frame, from the base object, shape (3,)."""
        return base.after(self._base).rotation.T @ self._down

    def gravity_angle(self, down: Array) -> float:
        """Angle between the model's gravity and a unit vector [rad]; 0 for a model without gravity."""
        if self._gravity is None:
            return 0.0
        return math.acos(float(np.clip(down @ self._gravity, -1.0, 1.0)))

    def markers(self, tip: Placement) -> tuple[Placement, Placement]:
        """Invert `tip`, for simulated Trackers: return tip and base object, with the rod's base at the world's origin
        and turned so that gravity points as the model has it."""
        base_frame = Placement(np.zeros(3), _turn(self._gravity, self._down))
        return base_frame.after(tip).after(_inverse(self._tip)), base_frame.after(_inverse(self._base))


def _inverse(placement: Placement) -> Placement:
    return WORLD.relative_to(placement)


def _turn(from_vector: Array | None, to_vector: Array) -> Array:
    """Return a rotation that takes one unit vector to another, shape (3, 3)."""
    if from_vector is None:
        return np.eye(3)
    axis, cosine = np.cross(from_vector, to_vector), float(from_vector @ to_vector)
    if cosine < -1.0 + 1e-9:
        other = np.eye(3)[int(np.argmin(np.abs(from_vector)))]
        axis = np.cross(from_vector, other)
        axis /= np.linalg.norm(axis)
        return np.asarray(2.0 * np.outer(axis, axis) - np.eye(3))
    cross = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    return np.asarray(np.eye(3) + cross + cross @ cross / (1.0 + cosine))


def euler_from_rotation(matrix: Array) -> Vector3:
    """Angles [rad] of order 'XYZ', shape of the input (3, 3); for simulated Trackers."""
    if abs(matrix[0, 2]) > 1.0 - 1e-12:  # x and z turn about the same axis
        return math.atan2(matrix[2, 1], matrix[1, 1]), math.copysign(0.5 * math.pi, matrix[0, 2]), 0.0
    return (
        math.atan2(-matrix[1, 2], matrix[2, 2]),
        math.asin(float(np.clip(matrix[0, 2], -1.0, 1.0))),
        math.atan2(-matrix[0, 1], matrix[0, 0]),
    )


def continued(matrix: Array, last: Quaternion | None) -> Quaternion:
    """Return the rotation's quaternion, with the sign that is closer to the last."""
    w, x, y, z = quaternion(matrix)
    if last is not None and w * last[0] + x * last[1] + y * last[2] + z * last[3] < 0.0:
        return -w, -x, -y, -z
    return w, x, y, z
