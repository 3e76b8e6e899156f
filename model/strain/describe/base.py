"""Pose and motion of a robot's base, as a moving platform or an arm prescribes them."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tendond.model.errors import ParameterError

Array = NDArray[np.float64]


def _none() -> Array:
    return np.zeros(3)


@dataclass(frozen=True)
class Base:
    """The base at an instant; all in the world frame.

    Attributes:
        rotation: body to world, shape (3, 3). position: [m], shape (3,).
        velocity: [m/s], shape (3,). spin: angular velocity [rad/s], shape (3,).
        acceleration: [m/s^2], shape (3,). spin_rate: angular acceleration [rad/s^2], shape (3,).
    """

    rotation: Array = field(default_factory=lambda: np.eye(3))
    position: Array = field(default_factory=_none)
    velocity: Array = field(default_factory=_none)
    spin: Array = field(default_factory=_none)
    acceleration: Array = field(default_factory=_none)
    spin_rate: Array = field(default_factory=_none)

    def __post_init__(self) -> None:
        for name in ("rotation", "position", "velocity", "spin", "acceleration", "spin_rate"):
            value = np.asarray(getattr(self, name), dtype=np.float64)
            shape = (3, 3) if name == "rotation" else (3,)
            if value.shape != shape or not np.all(np.isfinite(value)):
                raise ParameterError(f"base: {name} must be finite numbers, shape {shape}")
            object.__setattr__(self, name, value)
        if not np.allclose(self.rotation @ self.rotation.T, np.eye(3), atol=1e-9) or np.linalg.det(self.rotation) < 0.0:
            raise ParameterError("base: rotation is not a rotation matrix, shape (3, 3)")

    def at_rest(self) -> "Base":
        """Return the same pose, without motion."""
        return Base(self.rotation, self.position)

    def after(self, time: float) -> "Base":
        """Return the base a time later [s], its accelerations held."""
        turn = Rotation.from_rotvec(time * self.spin + 0.5 * time**2 * self.spin_rate).as_matrix()
        return replace(
            self,
            rotation=turn @ self.rotation,
            position=self.position + time * self.velocity + 0.5 * time**2 * self.acceleration,
            velocity=self.velocity + time * self.acceleration,
            spin=self.spin + time * self.spin_rate,
        )

    def velocity_at(self, points: Array) -> Array:
        """Return the velocity of what the base carries [m/s] at points in the world [m], shape (..., 3)."""
        return np.asarray(self.velocity + np.cross(self.spin, points - self.position))

    def row(self) -> Array:
        """Return 1 and all numbers in the order of the attributes, as the kernels take them, shape (25,)."""
        motion = (self.velocity, self.spin, self.acceleration, self.spin_rate)
        return np.concatenate(([1.0], self.rotation.reshape(-1), self.position, *motion))
