"""Pose and motion of a robot's base, as a moving platform or an arm prescribes them."""

from dataclasses import dataclass, field

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
        if not is_placed(self.row()):
            raise ParameterError("base: rotation is not a rotation matrix, shape (3, 3)")

    def at_rest(self) -> "Base":
        """Return the same pose, without motion."""
        return Base.from_row(at_rest(self.row()))

    def after(self, time: float) -> "Base":
        """Return the base a time later [s], its accelerations held."""
        return Base.from_row(later(self.row(), time))

    def velocity_at(self, points: Array) -> Array:
        """Return the velocity of what the base carries [m/s] at points in the world [m], shape (..., 3)."""
        return np.asarray(self.velocity + np.cross(self.spin, points - self.position))

    def row(self) -> Array:
        """Return 1 and all numbers in the order of the attributes, as the kernels take them, shape (25,)."""
        motion = (self.velocity, self.spin, self.acceleration, self.spin_rate)
        return np.concatenate(([1.0], self.rotation.reshape(-1), self.position, *motion))

    @staticmethod
    def from_row(row: Array) -> "Base":
        """Return the base of a row, shape (25,)."""
        kept = row.copy()
        return Base(kept[1:10].reshape(3, 3), *kept[10:].reshape(5, 3))


def later(rows: Array, time: float) -> Array:
    """Return rows of bases a time later [s], their accelerations held, shape (..., 25); zeros stay zeros."""
    found = rows.copy()
    motion = rows[..., 10:].reshape(*rows.shape[:-1], 5, 3)
    position, velocity, spin, acceleration, spin_rate = np.moveaxis(motion, -2, 0)
    turned = time * spin + 0.5 * time**2 * spin_rate
    turn = Rotation.from_rotvec(turned.reshape(-1, 3)).as_matrix().reshape(*rows.shape[:-1], 3, 3)
    found[..., 1:10] = (turn @ rows[..., 1:10].reshape(turn.shape)).reshape(*rows.shape[:-1], 9)
    found[..., 10:13] = position + time * velocity + 0.5 * time**2 * acceleration
    found[..., 13:16] = velocity + time * acceleration
    found[..., 16:19] = spin + time * spin_rate
    return found


def at_rest(rows: Array) -> Array:
    """Return rows of bases in the same poses, without motion, shape (..., 25)."""
    found = rows.copy()
    found[..., 13:] = 0.0
    return found


def is_placed(rows: Array) -> bool:
    """Return whether each row, of shape (..., 25), is zeros, or 1 and a rotation matrix first."""
    given = rows[rows.any(axis=-1)]
    rotation = given[:, 1:10].reshape(-1, 3, 3)
    across = np.allclose(rotation @ np.swapaxes(rotation, 1, 2), np.eye(3), atol=1e-9)
    return bool(np.all(given[:, 0] == 1.0) and across and np.all(np.linalg.det(rotation) > 0.0))
