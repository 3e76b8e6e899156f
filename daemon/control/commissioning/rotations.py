"""Rotations between their representations: matrix, axis times angle, quaternion."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def rotation_vectors(rotations: Array) -> Array:
    """Axis times angle [rad] of rotation matrices, shape (..., 3, 3) to (..., 3)."""
    r = rotations
    axial = 0.5 * np.stack(
        [r[..., 2, 1] - r[..., 1, 2], r[..., 0, 2] - r[..., 2, 0], r[..., 1, 0] - r[..., 0, 1]], axis=-1
    )
    sine = np.linalg.norm(axial, axis=-1)
    angle = np.arctan2(sine, 0.5 * (np.trace(r, axis1=-2, axis2=-1) - 1.0))
    # Half a turn has no sine, and its axis is the column of R + 1 that is longest.
    whole = r + np.eye(3)
    longest = np.argmax(np.linalg.norm(whole, axis=-2), axis=-1)
    column = np.take_along_axis(whole, longest[..., None, None], axis=-1)[..., 0]
    half = column / np.maximum(np.linalg.norm(column, axis=-1, keepdims=True), 1e-12)
    axis = np.where(sine[..., None] > 1e-6, axial / np.maximum(sine, 1e-12)[..., None], half)
    return np.where((angle < 1e-6)[..., None], axial, axis * angle[..., None])


def turn_by(vector: Array) -> Array:
    """Rotation matrix of axis times angle [rad], shape (3,) to (3, 3)."""
    angle = float(np.linalg.norm(vector))
    x, y, z = np.sin(0.5 * angle) / max(angle, 1e-12) * vector
    return rotation_matrix((float(np.cos(0.5 * angle)), x, y, z))


def rotation_matrix(quaternion: tuple[float, ...] | Array) -> Array:
    """Rotation matrix of a quaternion w, x, y, z of about unit size, shape (3, 3)."""
    w, x, y, z = np.asarray(quaternion) / np.linalg.norm(quaternion)
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )
