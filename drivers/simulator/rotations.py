"""Rotations of the simulated rig: small turns of an orientation, and the derivative of a rotation vector."""

import numpy as np
from numpy.typing import NDArray

from tendond.schemas.base import Quaternion

Array = NDArray[np.float64]


def turned(orientation: Quaternion, half: Array) -> Quaternion:
    """Turn an orientation, body to base, about its own axes by a small rotation, of which `half` is given [rad]."""
    w, x, y, z = orientation
    a, b, c = half
    found = np.array([w - a * x - b * y - c * z, x + a * w - b * z + c * y,
                      y + b * w - c * x + a * z, z + c * w - a * y + b * x])  # fmt: skip
    w, x, y, z = (found / np.linalg.norm(found)).tolist()
    return w, x, y, z


def right_jacobian(turn: Array) -> Array:
    """Return J_r of rotation vectors, with R' = R hat(J_r turn'), shapes (places, 3) to (places, 3, 3).

    Its transpose is the left one. J. Sola, J. Deray, D. Atchuthan, "A micro Lie theory for state estimation in
    robotics", 2018, equations 143 and 145.
    """
    angle = np.linalg.norm(turn, axis=1)[:, None, None]
    x, y, z = turn.T
    nothing = np.zeros_like(x)
    hat = np.array([[nothing, -z, y], [z, nothing, -x], [-y, x, nothing]]).transpose(2, 0, 1)
    half = np.sinc(0.5 * angle / np.pi)  # sin(angle/2) / (angle/2)
    small = angle < 1e-4
    third = np.where(small, 1.0 / 6.0, (1.0 - np.sinc(angle / np.pi)) / np.where(small, 1.0, angle) ** 2)
    return np.asarray(np.eye(3) - 0.5 * half**2 * hat + third * hat @ hat)
