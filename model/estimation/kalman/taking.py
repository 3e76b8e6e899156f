"""Readings in the memory: each at its own time, and only as far as it can belong to this robot."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tendond.model.estimation.kalman.factored import Factors
from tendond.model.estimation.kalman.memory import Expected, Index, Labels, Moment, Reading, Taken
from tendond.model.estimation.kalman.sensors import Sensor
from tendond.model.estimation.kalman.state import EstimatorState

Array = NDArray[np.float64]

GATE = 50.0
"""Square of a group's innovation in units of its expected spread, above which it is not believed: of three numbers
once in 1e10 by chance. The tip's pose has checks of its own before it gets here, and is always believed."""


SWAPPED = 0.25
"""Distance from another marker's place, of that from its own, below which a marker has the wrong label. Chosen."""


def place(
    estimate: EstimatorState, readings: Sequence[Reading], sensors: Sequence[Sensor], period: float
) -> tuple[list[Moment], set[int], Array | None]:
    """Put readings to the moments at which they were taken.

    Returns:
        The moments, the ticks of those that have a new reading, and the innovation of the newest pose [m], if any.
    """
    moments, fresh, innovation = list(estimate.moments), set(), None
    last = len(moments) - 1
    for reading in readings:
        back = min(max(reading.age, 0.0) / period, float(last))
        whole = math.floor(back)
        at = moments[last - round(back)]
        later, earlier = moments[last - whole], moments[max(0, last - whole - 1)]
        lack = _lack(reading, later, earlier, back - whole)
        rows = at.expected[reading.sensor].rows
        if reading.sensor == 0:
            innovation = lack[:3]
        lack = lack + rows @ at.after
        known = np.flatnonzero(np.isfinite(lack))
        variance = sensors[reading.sensor].deviation[known] ** 2
        taken = Taken(
            rows[known], lack[known], variance, reading.sensor, labels_of(reading, at.expected[reading.sensor], known)
        )
        moments[at.tick - moments[0].tick] = replace(at, taken=(*at.taken, taken))
        fresh.add(at.tick)
    return moments, fresh, innovation


def labels_of(reading: Reading, expected: Expected, known: Index) -> Labels | None:
    """Return the labels of a reading's `known` numbers; none of a pose."""
    if reading.sensor == 0:
        return None
    return Labels(known.astype(np.int64), reading.value[known], expected.value)


def _lack(reading: Reading, later: Moment, earlier: Moment, part: float) -> Array:
    """Measured minus estimated; `part`: of the way from the later to the earlier cycle."""
    one = later.expected[reading.sensor]
    lack = _from(reading, one, later.after)
    if part > 0.0:
        lack = lack + part * (_from(reading, earlier.expected[reading.sensor], earlier.after) - lack)
    return lack


def _from(reading: Reading, expected: Expected, deviation: Array) -> Array:
    """Measured minus estimated, had it been measured at that cycle."""
    lack = reading.value - expected.value
    if expected.rotation is not None and len(expected.rows) > 3:
        seen = reading.rotation
        turned = np.full(3, np.nan) if seen is None else small_rotation(seen @ expected.rotation.T)
        lack = np.concatenate((lack, turned))
    return np.asarray(lack - expected.rows[: len(lack)] @ deviation)


def small_rotation(rotation: Array) -> Array:
    """Return the rotation vector of a matrix, shape (3,)."""
    return np.asarray(Rotation.from_matrix(rotation).as_rotvec())


def believed(taken: Taken, factors: Factors, deviation: Array, group: int) -> tuple[Taken, float]:
    """Return what can be believed of a measurement, and the sum of squares of its innovations.

    Where one marker fits, those that do not are left out. Where none fits, it is the robot that is elsewhere: all are
    taken, with more noise. One that is close to another's place and far from its own has the wrong label, and never is.

    Args:
        taken: the measurement. factors: covariance before it. deviation: errors expected before it, shape (N,).
        group: numbers that are believed or refused together.
    """
    innovation = taken.lack - taken.rows @ deviation
    expected = factors.along(taken.rows) + np.diag(taken.variance)
    whole = _square(innovation, expected)
    if taken.sensor == 0 or len(innovation) == 0:
        return taken, whole
    parts = [np.arange(first, first + group) for first in range(0, len(innovation), group)]
    squares = [_square(innovation[part], expected[np.ix_(part, part)]) for part in parts]
    if max(squares) <= GATE:
        return taken, whole
    labelled = [part for part in parts if taken.labels is None or not _swapped(taken.labels.of(part))]
    kept = [part for part, square in zip(parts, squares, strict=True) if square <= GATE] or labelled
    rows = np.concatenate(kept) if kept else np.arange(0)
    labels = None if taken.labels is None else taken.labels.of(rows)
    left = Taken(taken.rows[rows], taken.lack[rows], taken.variance[rows], taken.sensor, labels)
    if len(rows) == 0:
        return left, 0.0
    square = _square(innovation[rows], expected[np.ix_(rows, rows)])
    if square > GATE * len(kept):
        left = replace(left, variance=left.variance * square / (GATE * len(kept)))
    return left, square


def _square(innovation: Array, expected: Array) -> float:
    """Square of an innovation in units of its expected spread."""
    return float(innovation @ np.linalg.solve(expected, innovation))


def _swapped(one: Labels) -> bool:
    """True if a marker is close to the place of another one, and far from its own."""
    group = len(one.seen)
    away = np.linalg.norm(one.places.reshape(-1, group) - one.seen, axis=1)
    own = int(one.numbers[0]) // group
    return bool(np.min(np.delete(away, own), initial=np.inf) < SWAPPED * away[own])
