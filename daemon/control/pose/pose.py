"""A pose of the tip, and the difference of two poses in one measure."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

Aim = Literal["across", "position", "turned", "direction", "pose"]
"""What of a pose counts: x and y; the position; the direction alone; position and direction (5 numbers); or position
and orientation (6)."""

RADIAN = 0.2
"""Distance that counts as much as a turn of 1 rad, of the backbone's length: 3 mm count as 2 degrees on a backbone of
0.43 m. Chosen: it decides only between position and direction where not both can be reached."""


_COUNTED = {"across": np.array([1.0, 1.0, 0.0]), "turned": np.zeros(3)}
"""Which components of the position count, where not all do."""


@dataclass(frozen=True)
class Pose:
    """Position [m], shape (3,), and rotation, body to world, shape (3, 3), of the tip; world frame."""

    position: Array
    rotation: Array

    @property
    def direction(self) -> Array:
        """Direction of the tip [-], shape (3,)."""
        return self.rotation[:, 2]


@dataclass(frozen=True)
class Miss:
    """Difference of a wanted pose and one that is there: distance [m] and angle [rad]."""

    distance: float
    angle: float

    def __str__(self) -> str:
        return f"{self.distance * 1e3:.1f} mm and {math.degrees(self.angle):.1f} degrees"


def turn(present: Pose, wanted: Pose, aim: Aim) -> Array:
    """Return the rotation vector from one pose to another [rad], world frame, shape (3,); zero where it does not count.

    For aims 'turned' and 'direction' it is the smallest turn that gives the direction.
    """
    if aim in ("across", "position"):
        return np.zeros(3)
    if aim == "pose":
        return np.asarray(Rotation.from_matrix(wanted.rotation @ present.rotation.T).as_rotvec())
    axis = np.cross(present.direction, wanted.direction)
    sine, cosine = float(np.linalg.norm(axis)), float(present.direction @ wanted.direction)
    if sine < 1e-12:
        return np.zeros(3) if cosine > 0.0 else math.pi * present.rotation[:, 0]
    return np.asarray(axis * (math.atan2(sine, cosine) / sine))


def miss(present: Pose, wanted: Pose, aim: Aim) -> Miss:
    """Return the distance and the angle between two poses, of what counts."""
    angle = float(np.linalg.norm(turn(present, wanted, aim)))
    return Miss(float(np.linalg.norm(_moved(present, wanted, aim))), angle)


def difference(present: Pose, wanted: Pose, aim: Aim, radian: float) -> Array:
    """Return position and turn to a wanted pose in one measure [m], shape (6,); `radian` [m] counts as 1 rad."""
    return np.concatenate((_moved(present, wanted, aim), radian * turn(present, wanted, aim)))


def _moved(present: Pose, wanted: Pose, aim: Aim) -> Array:
    """Return the displacement to a wanted pose, of what counts [m], shape (3,)."""
    return (wanted.position - present.position) * _COUNTED.get(aim, 1.0)


def counted(jacobian: Array, present: Pose, aim: Aim, radian: float) -> Array:
    """Return the derivative of a pose in the measure of `difference`.

    Args:
        jacobian: of position [m] and rotation vector [rad], shape (6, n).
        present: the pose there. aim, radian: see `difference`.
    """
    turned = radian * jacobian[3:]
    if aim in ("across", "position"):
        turned = np.zeros_like(turned)
    elif aim in ("turned", "direction"):
        turned = turned - np.outer(present.direction, present.direction @ turned)
    return np.vstack(((jacobian[:3].T * _COUNTED.get(aim, 1.0)).T, turned))


def rotation_to(direction: Array) -> Array:
    """Return a rotation, body to world, whose third axis is `direction`, turned from +z by the smallest angle."""
    straight = Pose(np.zeros(3), np.eye(3))
    axis = np.cross(straight.direction, direction)
    sine, cosine = float(np.linalg.norm(axis)), float(direction[2])
    if sine < 1e-12:
        return np.eye(3) if cosine > 0.0 else np.diag([1.0, -1.0, -1.0])
    return np.asarray(Rotation.from_rotvec(axis * (math.atan2(sine, cosine) / sine)).as_matrix())
