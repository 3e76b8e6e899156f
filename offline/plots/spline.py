"""A smooth curve through a few points. scipy's splines take a quarter of a second to import."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def smooth(points: Array, factor: int = 5) -> Array:
    """Return a natural cubic spline through points at equal steps of its parameter.

    The second derivatives M follow from M[i-1] + 4 M[i] + M[i+1] = 6 (y[i-1] - 2 y[i] + y[i+1]), and vanish at the ends
    (Press et al., Numerical Recipes, 3rd ed., 2007, section 3.3).

    Args:
        points: shape (k, n).
        factor: returned points for each of them.

    Returns:
        Shape (factor k, n), with the first and the last point at its ends; fewer than three points are returned as they
        are.
    """
    count = len(points)
    if count < 3:
        return points
    curvature = np.zeros_like(points)
    band = 4.0 * np.eye(count - 2) + np.eye(count - 2, k=1) + np.eye(count - 2, k=-1)
    curvature[1:-1] = np.linalg.solve(band, 6.0 * np.diff(points, 2, axis=0))
    at = np.linspace(0.0, count - 1.0, factor * count)
    low = np.minimum(at.astype(int), count - 2)
    right = (at - low)[:, None]
    left = 1.0 - right
    bend = (left**3 - left) * curvature[low] + (right**3 - right) * curvature[low + 1]
    curve: Array = left * points[low] + right * points[low + 1] + bend / 6.0
    return curve
