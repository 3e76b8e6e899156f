"""Conversion of rotation matrices to quaternions."""

import math

import numpy as np
from numpy.typing import NDArray


def quaternion(rotation: NDArray[np.float64]) -> tuple[float, float, float, float]:
    """Unit quaternion w, x, y, z with w >= 0 of a (nearly) orthonormal matrix, shape (3, 3), body to world.

    The largest of the four components is found first, so that nothing is lost near half a turn (Shepperd 1978).
    """
    (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = rotation.tolist()
    squares = (1.0 + r00 + r11 + r22, 1.0 + r00 - r11 - r22, 1.0 - r00 + r11 - r22, 1.0 - r00 - r11 + r22)
    products = (
        (squares[0], r21 - r12, r02 - r20, r10 - r01),
        (r21 - r12, squares[1], r10 + r01, r02 + r20),
        (r02 - r20, r10 + r01, squares[2], r21 + r12),
        (r10 - r01, r02 + r20, r21 + r12, squares[3]),
    )
    q = products[squares.index(max(squares))]
    size = math.copysign(math.hypot(*q), q[0])
    return q[0] / size, q[1] / size, q[2] / size, q[3] / size
