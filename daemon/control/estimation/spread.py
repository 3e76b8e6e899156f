"""Covariances of vectors in space, as people read them: deviations, and the ellipsoid that holds 95 %."""

import numpy as np
from numpy.typing import NDArray

from tendond.schemas.record import Covariance

Array = NDArray[np.float64]

CHI_SQUARE_95 = 7.815
"""Squared distance, in units of its spread, within which 95 % of a normal vector in space lie: chi-square with three
degrees of freedom (Bar-Shalom, Li and Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001)."""


def upper_half(matrix: Array) -> Covariance:
    """Return the upper half of a symmetric matrix, shape (3, 3), row by row."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = matrix.tolist()
    return xx, xy, xz, yy, yz, zz


def whole(half: Covariance) -> Array:
    """Return the symmetric matrix, shape (3, 3), of its upper half."""
    xx, xy, xz, yy, yz, zz = half
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def deviation_along(covariance: Covariance, vector: Array) -> float:
    """Return the standard deviation of a vector's length: along it, or where it is zero along the least certain axis.

    Args:
        covariance: of the vector, in the square of its unit.
        vector: shape (3,).
    """
    size = float(np.linalg.norm(vector))
    if size == 0.0:
        return float(np.sqrt(np.linalg.eigvalsh(whole(covariance))[-1]))
    along = vector / size
    return float(np.sqrt(np.maximum(along @ whole(covariance) @ along, 0.0)))


def ellipsoid(covariance: Covariance) -> tuple[Array, Array]:
    """Return the ellipsoid that holds 95 %: its half axes, shape (3,), the largest last, and their directions.

    The directions are the columns of a rotation, shape (3, 3).
    """
    squares, axes = np.linalg.eigh(whole(covariance))
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] = -axes[:, 0]
    return np.sqrt(CHI_SQUARE_95 * np.maximum(squares, 0.0)), axes
