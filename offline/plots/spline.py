"""A smooth curve through a few points. scipy's splines take a quarter of a second to import."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def smooth(points: Array, factor: int = 5) -> Array:
    """Return a natural cubic spline through points, by the distance along them: they may be unequally far apart.

    With the distances h[i] from point to point the second derivatives M follow from

        h[i-1] M[i-1] + 2 (h[i-1] + h[i]) M[i] + h[i] M[i+1] = 6 ((y[i+1] - y[i]) / h[i] - (y[i] - y[i-1]) / h[i-1])

    and vanish at the ends (Press et al., Numerical Recipes, 3rd ed., 2007, section 3.3).

    Args:
        points: shape (k, n).
        factor: returned points for each of them.

    Returns:
        Shape (factor k, n), with the first and the last point at its ends; fewer than three points, and points of which
        two neighbours are the same, are returned as they are.
    """
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if len(points) < 3 or not steps.min() > 0.0:
        return points
    slopes = np.diff(points, axis=0) / steps[:, None]
    band = np.diag(2.0 * (steps[:-1] + steps[1:])) + np.diag(steps[1:-1], 1) + np.diag(steps[1:-1], -1)
    curvature = np.zeros_like(points)
    curvature[1:-1] = np.linalg.solve(band, 6.0 * np.diff(slopes, axis=0))
    along = np.concatenate([[0.0], np.cumsum(steps)])
    at = np.linspace(0.0, along[-1], factor * len(points))
    low = np.clip(np.searchsorted(along, at, side="right") - 1, 0, len(steps) - 1)
    step = steps[low][:, None]
    right = ((at - along[low])[:, None]) / step
    left = 1.0 - right
    bend = step**2 * ((left**3 - left) * curvature[low] + (right**3 - right) * curvature[low + 1])
    curve: Array = left * points[low] + right * points[low + 1] + bend / 6.0
    return curve
