"""The backbone as a smooth curve, for display."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def hermite_curve(places: Array, strains: Array, ds: float, points: int) -> Array:
    """Interpolate equally spaced points from base to tip, world frame [m], shape (points, 3).

    Cubic Hermite interpolation of the nodes with their tangents R v; the error falls with the fourth power of their
    distance.

    Args:
        places: p and R of each node, shape (nodes, 12).
        strains: v - v* of each, shape (nodes, 3).
        ds: distance of the nodes [m].
        points: points of the curve.
    """
    stretched = strains + np.array((0.0, 0.0, 1.0))
    tangent = np.einsum("kij,kj->ki", places[:, 3:].reshape(-1, 3, 3), stretched) * ds
    at = np.linspace(0.0, len(places) - 1, points)
    first = np.minimum(at.astype(np.intp), len(places) - 2)
    t = (at - first)[:, None]
    start, end = places[first, :3], places[first + 1, :3]
    return np.asarray(
        (1.0 + 2.0 * t) * (1.0 - t) ** 2 * start
        + t * (1.0 - t) ** 2 * tangent[first]
        + t**2 * (3.0 - 2.0 * t) * end
        + t**2 * (t - 1.0) * tangent[first + 1]
    )
