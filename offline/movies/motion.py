"""What moves in a movie: shapes between recorded ones, forces as arrows."""

import numpy as np
from numpy.typing import NDArray

from tendond.offline.logs.log import LogFile

Array = NDArray[np.float64]


def held_force(log: LogFile, ticks: NDArray[np.int64]) -> Array:
    """Return the true force on the tip at each tick [N], shape (k, 3): the newest, where a cycle has none beside it."""
    known = np.searchsorted(log.truth_ticks, ticks, side="right") - 1
    return np.array([log.truth[i].tip_force if i >= 0 else (0.0, 0.0, 0.0) for i in known])


def between(one: Array, other: Array, part: float) -> Array:
    """Return the points a part of the way from one shape to another; the other, where they do not have as many."""
    return other if one.shape != other.shape else (1.0 - part) * one + part * other


def arrow(place: Array, along: Array, head: float, across: int) -> Array:
    """Return the points of an arrow's line, shape (5, 3).

    Args:
        place: its beginning. along: from there to its end, not zero. head: greatest length of its head.
        across: index of the axis to which the head is perpendicular, if the arrow is not along that.
    """
    end, length = place + along, float(np.linalg.norm(along))
    aside = np.cross(along, np.eye(3)[across])
    if np.linalg.norm(aside) < 1e-9 * length:
        aside = np.cross(along, np.eye(3)[(across + 1) % 3])
    size = min(head, 0.5 * length)
    aside *= 0.5 * size / float(np.linalg.norm(aside))
    back = -size * along / length
    return np.array([place, end, end + back + aside, end, end + back - aside])
