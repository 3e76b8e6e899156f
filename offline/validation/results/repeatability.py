"""Scatter of the measurement itself: tips at nearly the same commands, reached at different times or sides.

Two poses whose commands are nearly equal differ by what a function of the command cannot know: friction, creep, slips,
noise. With a model's difference between the two commands taken away, the scatter's root mean square is a lower bound
of the error of any model without memory.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Repeatability:
    """Pairs of poses with nearly the same commands.

    Attributes:
        pairs: number of them. near: largest distance of their commands [m]. apart: least number of poses between them.
        rms: scatter of one pose [m], root mean square of the pairs' difference over the root of two.
        median: of it [m]. model_rms: error of the model at the same poses [m].
    """

    pairs: int
    near: float
    apart: int
    rms: float
    median: float
    model_rms: float

    @property
    def share(self) -> float:
        """Part of the model's squared error at these poses that no function of the command can remove."""
        return min(1.0, (self.rms / self.model_rms) ** 2) if self.model_rms > 0.0 else np.nan


def repeatability(command: Array, error: Array, near: float, apart: int) -> Repeatability:
    """Return the scatter of poses whose commands are at most `near` [m] and at least `apart` poses from each other.

    Args:
        command: [m], shape (N, m), in the order of the sequence.
        error: of a model without memory, predicted minus measured [m], shape (N, 3).
        near: distance of commands [m]. apart: of numbers in the sequence.
    """
    pairs = cKDTree(command).query_pairs(near, output_type="ndarray")
    pairs = pairs[np.abs(pairs[:, 0] - pairs[:, 1]) >= apart] if len(pairs) else np.zeros((0, 2), dtype=np.int64)
    if not len(pairs):
        return Repeatability(0, near, apart, np.nan, np.nan, np.nan)
    differ = np.linalg.norm(error[pairs[:, 0]] - error[pairs[:, 1]], axis=1) / np.sqrt(2.0)
    own = np.linalg.norm(error[pairs.reshape(-1)], axis=1)
    root = float(np.sqrt(np.mean(own**2)))
    return Repeatability(len(pairs), near, apart, float(np.sqrt(np.mean(differ**2))), float(np.median(differ)), root)


@dataclass(frozen=True)
class Jump:
    """A jump of the tip between two poses with nearly the same commands, one after the other.

    Attributes:
        pose: number of the second one. size: of the change of the model's error [m].
    """

    pose: int
    size: float


def jumps(command: Array, error: Array, near: float, size: float) -> list[Jump]:
    """Return changes of the error by more than `size` [m] from one pose to the next that are there ten poses later."""
    width = 10
    change = np.linalg.norm(np.diff(error, axis=0), axis=1)
    step = np.linalg.norm(np.diff(command, axis=0), axis=1)
    found = []
    for i in np.flatnonzero((change > size) & (step <= near)) + 1:
        before, after = error[max(0, i - width) : i], error[i : i + width]
        apart = float(np.linalg.norm(np.median(after, axis=0) - np.median(before, axis=0)))
        if apart > size and len(before) == len(after) == width:
            found.append(Jump(int(i), apart))
    return found
