"""A servo's dynamics from a recorded run: its reports against the commands that it was given."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from tendond.model.tendons.servo import ServoDynamics, advance, at_rest
from tendond.model.tendons.servo_fit import SMALLEST, START, ServoFit
from tendond.offline.identification.recordings.recording import DataError, Recording

Array = NDArray[np.float64]

TRAVEL = 0.002
"""Min. travel of the reports that can be fitted to [m]: that of a servo that hardly moves is lost in its play."""

READINGS = 50
"""Min. number of reports."""

LONGEST = 20.0
"""Time of the log that is fitted to [s], its first armed stretches: more costs time and changes little."""

SHOWN = 0.25
"""Relative standard error of the rate and the acceleration above which the log does not show them."""


def fit_recording(recording: Recording, tendon: int, rate: float, acceleration: float) -> tuple[ServoFit, float]:
    """Fit dead time, speed, acceleration, lag and backlash of a servo to a recording.

    Args:
        recording: of a run. tendon: number of the servo's tendon.
        rate, acceleration: those of its profile, from which the fit begins [m/s, m/s^2].

    Returns:
        The dynamics, and the backlash [m].

    Raises:
        DataError: no such tendon, no reports, or too little motion.
    """
    path, tendons = recording.path, recording.command.shape[1]
    if not 0 <= tendon < tendons:
        raise DataError(f"{path}: there is no tendon {tendon}: they are 0 to {tendons - 1}")
    if recording.ideal_drive:
        raise DataError(f"{path}: a simulator's ideal drive has no servos: record with simulator.drive = displacement")
    stretches = list(_stretches(recording, tendon))
    count = sum(len(times) for _, times, _ in stretches)
    if count < READINGS:
        raise DataError(f"{path}: has {count} reports of servo {tendon} while armed: {READINGS} or more are needed")
    reported = np.concatenate([positions for _, _, positions in stretches])
    if np.ptp(reported) < TRAVEL:
        raise DataError(
            f"{path}: tendon {tendon} moved by {np.ptp(reported) * 1e3:.1f} mm: {TRAVEL * 1e3:g} mm or more are needed"
        )

    def residuals(logarithms: Array) -> Array:
        dead_time, *rest = np.exp(logarithms).tolist()
        servo = ServoDynamics(*rest)
        moved = [_reports(servo, dead_time, commands, times, float(at[0])) for commands, times, at in stretches]
        return np.asarray(np.concatenate(moved) - reported)

    first = np.log([START[0], rate, acceleration, START[1], 10.0 * SMALLEST])
    low = np.log([SMALLEST, 0.1 * rate, 0.1 * acceleration, SMALLEST, 0.01 * SMALLEST])
    high = np.log([0.2, 10.0 * rate, 10.0 * acceleration, 0.5, 0.005])
    found = least_squares(residuals, first, bounds=(low, high), x_scale=0.1, diff_step=np.full(5, 1e-4))
    values, slope = np.exp(found.x), np.asarray(found.jac, dtype=np.float64)
    variance = 2.0 * found.cost / (count - len(values))
    alone = 1.0 / np.maximum(np.sum(slope**2, axis=0), 1e-300)  # of what nothing depends on: unbounded
    errors = values * np.sqrt(np.maximum(np.diag(np.linalg.pinv(slope.T @ slope)), alone) * variance)
    dead_time, fastest, fitted, lag, backlash = values.tolist()
    one, two, three, four, _ = errors.tolist()
    residual = float(np.sqrt(np.mean(found.fun**2)))
    return ServoFit(ServoDynamics(fastest, fitted, lag), dead_time, (one, two, three, four), residual), backlash


def _stretches(recording: Recording, tendon: int) -> Iterator[tuple[tuple[Array, Array], Array, Array]]:
    """Yield commands (times, goals), times of reports and reported positions of each armed stretch, up to `LONGEST`."""
    edges = np.flatnonzero(np.diff(recording.armed.astype(int))) + 1
    left = LONGEST
    for part in np.split(np.arange(len(recording.times)), edges):
        if not recording.armed[part[0]] or left <= 0.0:
            continue
        times = recording.times[part]
        times = times[times <= times[0] + left]
        left -= float(times[-1] - times[0])
        here = (recording.report_times >= times[0]) & (recording.report_times <= times[-1])
        if np.count_nonzero(here) > 1:
            goals = recording.command[part[: len(times)], tendon]
            yield (times, goals), recording.report_times[here], recording.reported[here, tendon]


def _reports(
    servo: ServoDynamics, dead_time: float, commands: tuple[Array, Array], times: Array, first: float
) -> Array:
    """Return where the tendon's end is at the times of the reports [m], shape (k,), from rest at `first` [m]."""
    given, goals = commands[0] + dead_time, commands[1]
    state, now, goal, found = at_rest(first), float(times[0]), first, []
    events = sorted([(float(at), 0, float(value)) for at, value in zip(given, goals, strict=True)]
                    + [(float(at), 1, 0.0) for at in times])  # fmt: skip
    for at, is_report, value in events:
        if at > now:
            state, now = advance(servo, state, goal, at - now), at
        if is_report:
            found.append(state.end)
        else:
            goal = value
    return np.array(found)
