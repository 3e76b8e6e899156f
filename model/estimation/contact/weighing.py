"""Onset, place and force of a contact, from the traces of the last cycles."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.estimation.contact.shocks import gather, measure_back, step_back, weigh_onsets
from tendond.model.estimation.contact.state import Trace
from tendond.model.numerics.compile import Bound
from tendond.model.rods.stations import Stations

Array = NDArray[np.float64]

AXIAL = 400.0
"""Information beforehand on a force along the backbone, in that on one across it: a body that touches the robot presses
across it. A force along a straight arm leaves no trace, and on a bent one explains what friction does."""

EXCLUDED, EXCLUDED_SHARE = 3.84, 0.05
"""By how much the statistic of a place that is excluded lies below the best one's: 95 % of chi-square with one degree
of freedom, and a share of the best one for a robot that is not its model. `tendond study contact` has the coverage."""


class Weighed(NamedTuple):
    """Statistic, onset [ticks] and force [N] of the likeliest onset at each station, shapes (p,), (p,), (p, 3)."""

    statistic: Array
    onset: Array
    force: Array


class Fit(NamedTuple):
    """A force at one place from one onset on.

    Attributes:
        force: the likeliest [N], shape (3,). covariance: of it [N^2], shape (3, 3). statistic: twice the log of its
            likelihood ratio.
        errors: by each component of it, before the newest measurement, shape (N, 3).
        information, score: on it, shapes (3, 3) and (3,).
    """

    force: Array
    covariance: Array
    statistic: float
    errors: Array
    information: Array
    score: Array

    def statistic_of(self, force: Array) -> float:
        """Return twice the log of the likelihood ratio of a given force [N], shape (3,)."""
        return float(2.0 * force @ self.score - force @ self.information @ force)


class Weigher:
    """The passes over the traces.

    Args:
        stations: places that are weighed. decay: lower diagonal of the errors' transition, shape (N - 2 k,).
        size: N. deviation: standard deviation of a force beforehand [N].
    """

    def __init__(self, stations: Stations, decay: Array, size: int, deviation: float) -> None:
        self._stations, self._decay, self._size = stations, decay, size
        self._known = 1.0 / deviation**2
        p = len(stations.at)
        self._r, self._m, self._y = np.zeros(size), np.zeros((size, size)), np.zeros((size, 3 * p))
        self._pushed, self._square = np.zeros((size, 3 * p)), np.zeros((size, max(size, 3 * p)))
        self._score, self._information = np.zeros((p, 3)), np.zeros((2, p, 3, 3))
        self._small = np.zeros((5, 3))
        self._measure_back, self._step_back = Bound(measure_back), Bound(step_back)
        self._gather, self._weigh = Bound(gather), Bound(weigh_onsets)

    def prior(self, axial: Array) -> Array:
        """Return the information on forces beforehand, by the backbone's directions, shapes (p, 3, 3) and (p, 3)."""
        along = axial[:, :, None] * axial[:, None, :]
        return np.asarray(self._known * (np.eye(3) + AXIAL * along))

    def weigh(self, traces: Sequence[Trace], tick: int) -> Weighed:
        """Weigh all onsets within the traces, and all stations; `tick`: of the newest trace."""
        p = len(self._stations.at)
        statistic, onset, force = np.zeros(p), np.full(p, float(tick)), np.zeros((p, 3))
        r, m, y = self._r, self._m, self._y
        r[:], m[:], y[:] = 0.0, 0.0, 0.0
        score, information, prior = np.zeros((p, 3)), np.zeros((p, 3, 3)), self.prior(traces[-1].axial)
        rows = max(len(trace.innovation) for trace in traces)
        room = np.zeros((2 * max(rows, 1), max(self._size, 3 * p, rows)))
        for back, trace in enumerate(reversed(traces)):
            self._measure_back.call(trace.white, trace.gain, trace.innovation, r, m, y, room)
            self._gather.call(trace.push, r, m, y, self._pushed, self._score, self._information)
            steps = self._score, self._information, prior, self._small
            self._weigh.call(score, information, *steps, tick - back, force, statistic, onset)
            score += self._score
            information += self._information[0] + self._information[1]
            self._step_back.call(trace.top, self._decay, trace.push, r, m, y, self._pushed, self._square)
        return Weighed(statistic, onset, force)

    def fit(self, traces: Sequence[Trace], tick: int, onset: float, place: float) -> Fit:
        """Fit a force at an arc length [m] from an onset on [ticks]; `tick`: of the newest trace."""
        weights, k = self._stations.weights(place), len(traces[0].top)
        errors, information, score = np.zeros((self._size, 3)), np.zeros((3, 3)), np.zeros(3)
        first = tick - len(traces) + 1
        begin, after = max(0, math.ceil(onset) - first), errors
        for index in range(begin, len(traces)):
            trace = traces[index]
            push = np.tensordot(trace.push.reshape(k, -1, 3), weights, axes=(1, 0))
            lower = self._decay[:, None] * after[k:]
            errors = np.vstack((trace.top @ after + min(1.0, first + index - onset) * push, lower))
            seen = trace.white @ errors
            information += seen.T @ seen
            score += seen.T @ trace.innovation
            after = errors - trace.gain.T @ seen
        at = weights @ traces[-1].axial
        information += self._known * (np.eye(3) + AXIAL * np.outer(at, at))
        covariance: Array = np.asarray(np.linalg.inv(information), dtype=np.float64)
        force = covariance @ score
        return Fit(force, covariance, float(score @ force), errors, information, score)

    def locate(self, weighed: Weighed) -> tuple[float, float, float]:
        """Return the likeliest place, and the first and the last one that are not excluded [m]."""
        at, statistic = self._stations.at, weighed.statistic
        best = int(np.argmax(statistic))
        place, top = float(at[best]), float(statistic[best])
        if 0 < best < len(at) - 1:
            x, y = at[best - 1 : best + 2] - at[best], statistic[best - 1 : best + 2] - top
            left, right = y[0] / x[0], y[2] / x[2]
            bend = (right - left) / (x[2] - x[0])
            slope = left - bend * x[0]
            if bend < 0.0:
                moved = float(min(max(-slope / (2.0 * bend), x[0]), x[2]))
                place, top = place + moved, float(top + slope * moved + bend * moved**2)
        knots, heights = np.append(at, place), np.append(statistic, top)
        order = np.argsort(knots, kind="stable")
        fine = np.linspace(0.0, at[-1], INTERVAL_POINTS)
        known = np.interp(fine, np.append(0.0, knots[order]), np.append(0.0, heights[order]))
        inside = fine[known >= top - EXCLUDED - EXCLUDED_SHARE * top]
        return (
            place,
            min(float(inside[0]), place) if len(inside) else place,
            (max(float(inside[-1]), place) if len(inside) else place),
        )


INTERVAL_POINTS = 201
"""Places that are looked at for the interval: half a percent of the robot."""
