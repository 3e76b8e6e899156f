"""Servos through a recording: where they are by the commands, with a lag and a backlash, or by their reports."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.optimize import minimize_scalar

from tendond.offline.identification.recordings.recording import Recording

Array = NDArray[np.float64]

NO_LAG = 1e-6
"""Lag [s] that stands for none."""

SETTLING = 0.3
"""Time after the torque comes on [s] in which the servos move from their previous positions."""


def shaft(recording: Recording, times: Array, lag: float) -> Array:
    """Compute the shafts' displacement by the commands and a first-order lag; exact between commands.

    A servo whose torque comes on starts at its first command.

    Args:
        recording: the commands.
        times: times [s], shape (k,).
        lag: time constant [s].

    Returns:
        Displacements [m], shape (k, n).
    """
    at, command = recording.times, recording.command
    lag = max(lag, NO_LAG)
    left = np.exp(-np.diff(at) / lag)
    reached = command.copy()  # when each command is given
    for k in range(1, len(at)):
        if recording.armed[k - 1]:
            reached[k] = command[k - 1] + left[k - 1] * (reached[k - 1] - command[k - 1])
    now = np.clip(np.searchsorted(at, times + 1e-9, side="right") - 1, 0, len(at) - 1)
    fading = np.exp(-np.maximum(times - at[now], 0.0) / lag)[:, None]
    return np.asarray(command[now] + fading * (reached[now] - command[now]))


def tendon_ends(recording: Recording, times: Array, lag: float, backlash: float) -> Array:
    """Compute the displacement of the tendons' ends, which the shafts move through a backlash.

    Args:
        recording: the commands.
        times: times [s], shape (k,).
        lag: time constant of the shafts [s].
        backlash: play of the gears, as a displacement [m].

    Returns:
        Displacements [m], shape (k, n).
    """
    knots = np.union1d(recording.times, times)  # between two of them a shaft turns in one direction only
    ends = shaft(recording, knots, lag)
    if backlash > 0.0:
        now = np.searchsorted(recording.times, knots + 1e-9, side="right") - 1
        armed = recording.armed[np.maximum(now, 0)]
        play, end = 0.5 * backlash, ends[0]
        low, high = ends - play, ends + play
        for k in range(1, len(knots)):
            end = np.minimum(np.maximum(end, low[k]), high[k]) if armed[k - 1] else ends[k]
            ends[k] = end
    return np.asarray(ends[np.searchsorted(knots, times)])


def settled_reports(recording: Recording) -> NDArray[np.bool_]:
    """Mark the reports of servos whose torque has been on for `SETTLING`, shape (r,)."""
    before = np.searchsorted(recording.times, recording.report_times - 1e-9) - 1
    on = np.flatnonzero(recording.armed & ~np.r_[False, recording.armed[:-1]])
    if not on.size:
        return np.zeros(len(before), dtype=bool)
    last = np.searchsorted(on, before, side="right") - 1
    since = recording.report_times - recording.times[on[np.maximum(last, 0)]]
    return np.asarray((before >= 0) & (last >= 0) & recording.armed[before] & (since > SETTLING + 1e-9))


def reported_ends(recording: Recording, where: Array, stretches: Sequence[tuple[int, int]], step: float) -> Array:
    """Interpolate the servos' reports to other times, where the servos are armed.

    Between two reports either as a smooth curve, or as commands and lag predict: whichever predicts every second report
    better from the others.

    Args:
        recording: reports and commands.
        where: times [s], a `step` apart, shape (k,).
        stretches: first and end index in `where` of the stretches with the torque on or off.
        step: time step [s].

    Returns:
        Displacements [m], shape (k, n).
    """
    count = settled_reports(recording)

    def off(lag: float) -> float:
        apart = shaft(recording, recording.report_times[count], lag) - recording.reported[count]
        return float(np.sum(apart**2))

    def filled(reported: Array, every: int, at: Array) -> Array:
        return _filled(
            recording.report_times, reported, every, at, [(where[i], where[j - 1]) for i, j in stretches], step
        )

    lag = float(minimize_scalar(off, bounds=(NO_LAG, 0.3), method="bounded").x)
    times = recording.report_times
    expected, at = shaft(recording, times, lag), shaft(recording, where, lag)
    missed = [
        float(np.sum((filled(y, 2, times) - y)[count] ** 2))
        for y in (recording.reported - expected, recording.reported)
    ]
    if missed[0] < missed[1]:
        return np.asarray(at + filled(recording.reported - expected, 1, where))
    return filled(recording.reported, 1, where)


def _filled(
    times: Array, reported: Array, every: int, where: Array, stretches: Sequence[tuple[float, float]], step: float
) -> Array:
    """Interpolate each `every`th report [m] to other times, shape (len(where), n); each stretch [s] by itself."""
    filled = np.zeros((len(where), reported.shape[1]))
    for first, last in stretches:
        start, stop = first - step, last + step
        rows = np.flatnonzero((times >= start) & (times <= stop))[::every]
        inside = (where >= start) & (where <= stop)
        if len(rows) >= 2:
            points = np.clip(where[inside], times[rows[0]], times[rows[-1]])
            filled[inside] = PchipInterpolator(times[rows], reported[rows])(points)
    return filled
