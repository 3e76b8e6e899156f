"""Between rotation matrices and quaternions."""

import math

import numpy as np
from numpy.typing import NDArray


def quaternion(rotation: NDArray[np.float64]) -> tuple[float, float, float, float]:
    """Unit quaternion w, x, y, z with w >= 0 of a (nearly) orthonormal matrix, shape (3, 3), body to world.

    The largest of the four components is found first, so that nothing is lost near half a turn (Shepperd 1978).
    """
    r = rotation
    squares = np.array(
        [
            1.0 + r[0, 0] + r[1, 1] + r[2, 2],
            1.0 + r[0, 0] - r[1, 1] - r[2, 2],
            1.0 - r[0, 0] + r[1, 1] - r[2, 2],
            1.0 - r[0, 0] - r[1, 1] + r[2, 2],
        ]
    )
    products = np.array(
        [
            [squares[0], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], squares[1], r[1, 0] + r[0, 1], r[0, 2] + r[2, 0]],
            [r[0, 2] - r[2, 0], r[1, 0] + r[0, 1], squares[2], r[2, 1] + r[1, 2]],
            [r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[2, 1] + r[1, 2], squares[3]],
        ]
    )
    q = products[int(np.argmax(squares))]
    q = q / math.hypot(*q.tolist())
    w, x, y, z = (q if q[0] >= 0.0 else -q).tolist()
    return w, x, y, z
