"""Errors of predicted tips: root mean square, percentiles, by tendon."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PERCENTILES = (50, 90, 95)


@dataclass(frozen=True)
class Errors:
    """Distances between predicted and measured tips.

    Attributes:
        count: of poses. rms: root of the mean squared distance [m]. percentiles: 50th, 90th, 95th [m]. largest: [m].
        bias: mean error, camera's frame [m], shape (3,).
    """

    count: int
    rms: float
    percentiles: tuple[float, ...]
    largest: float
    bias: tuple[float, ...]


def errors_of(predicted: Array, measured: Array) -> Errors:
    """Return the errors of tips, shape (N, 3) [m]; NaN where there are none."""
    apart = predicted - measured
    distance = np.linalg.norm(apart, axis=1)
    if not len(distance):
        return Errors(0, np.nan, (np.nan,) * len(PERCENTILES), np.nan, (np.nan,) * 3)
    return Errors(
        len(distance),
        float(np.sqrt(np.mean(distance**2))),
        tuple(float(one) for one in np.percentile(distance, PERCENTILES)),
        float(distance.max()),
        tuple(float(one) for one in apart.mean(axis=0)),
    )


def by_tendon(predicted: Array, measured: Array, command: Array) -> list[Errors]:
    """Return the errors of the poses in which each tendon is the one that is pulled most, m of them."""
    most = np.argmax(command, axis=1)
    return [errors_of(predicted[most == i], measured[most == i]) for i in range(command.shape[1])]
