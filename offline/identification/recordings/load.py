"""Reading a recording from a log."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.offline.identification.recordings.recording import DataError, Recording
from tendond.offline.identification.recordings.weights import weight_of
from tendond.offline.logs.arrays import LOG_TIME, Arrays, load
from tendond.schemas.messages import Mode

Array = NDArray[np.float64]


REST_SECONDS = 0.3
"""Time that the arm must be at rest before a motion [s], so that its state is known."""


STILL = 3e-4
"""Spread of the tip's position that counts as rest [m], or three times the noise where that is more."""


STRANGE_AGE = 0.5
"""Scatter of the poses' ages [s] above which they are not used: publisher and controller have different clocks."""


def load_recording(path: Path, weights: Mapping[str, float], *, from_rest: bool = True) -> Recording:
    """Read a log.

    Args:
        path: the log.
        weights: weights on the tip [kg], by path or file name; these override the log's own.
        from_rest: whether the recording begins at the first rest, as the rod's motion must; else with the log.

    Raises:
        LogError: the log cannot be read.
        DataError: the log has no poses, or no rest from which the motion could be computed.
    """
    arrays = load(path)
    period = arrays.config.loop.period
    missed = np.cumsum(arrays["inputs.missed_ticks"])
    cycle = (arrays["tick"] - arrays["tick"][0] + missed) * period
    fresh = _fresh(arrays)
    if not np.any(fresh):
        raise DataError(f"{path}: has no pose of the tip that the controller accepted: nothing to fit to")
    noise = _noise(arrays["measured"][fresh])
    modes = arrays["mode"]
    faults = np.flatnonzero(modes == Mode.FAULT.value)
    end = int(faults[0]) if faults.size else len(arrays)
    fault = str(arrays["reason"][end]) if faults.size else ""
    command = np.atleast_2d(arrays["command.displacement"])
    armed = arrays["command.armed"].astype(bool)
    first: int | None = 0
    if from_rest:
        first = _first_rest(cycle, command, armed, fresh, arrays["measured"], max(STILL, 3.0 * noise), end)
    if first is None:
        raise DataError(
            f"{path}: the arm is never at rest for {REST_SECONDS:g} s before it moves, so the initial state "
            "of the motion is not known: record a rest first"
        )
    part = slice(first, end)
    origin = cycle[first]
    rows = np.flatnonzero(fresh[part]) + first
    limited = arrays["limited"][part] != ""
    reports = _reports(arrays, cycle, part)
    return Recording(
        path=path,
        config=arrays.config,
        weight=weight_of(arrays, path, weights),
        period=period,
        times=cycle[part] - origin,
        armed=armed[part],
        command=command[part],
        report_times=reports[0] - origin,
        reported=reports[1],
        pulled=reports[2],
        pose_times=cycle[rows] - origin - _jitter(arrays, rows),
        position=arrays["measured"][rows],
        noise=noise,
        cycles=len(arrays),
        hidden=int(len(arrays) - np.count_nonzero(fresh)),
        limited=float(np.mean(limited[armed[part]])) if np.any(armed[part]) else 0.0,
        missed=int(missed[-1]),
        fault=fault,
        ideal_drive="truth.position" in arrays.arrays and arrays.config.simulator.drive == "tension",
    )


def _fresh(arrays: Arrays) -> NDArray[np.bool_]:
    """Mark the cycles in which a new pose was accepted, shape (cycles,)."""
    return np.asarray(np.asarray(arrays.arrays.get("pose_age", np.full(len(arrays), np.nan)), dtype=float) == 0.0)


def _noise(position: Array) -> float:
    """Estimate the noise of a coordinate [m] from third differences, which a smooth motion hardly affects."""
    if len(position) < 8:
        return 0.0
    third = np.diff(position, 3, axis=0)
    return float(np.median(np.abs(third)) / 0.6745 / math.sqrt(20.0))


def _first_rest(
    times: Array,
    command: Array,
    armed: NDArray[np.bool_],
    fresh: NDArray[np.bool_],
    position: Array,
    still: float,
    end: int,
) -> int | None:
    """Find the first cycle of the first rest."""
    width = max(2, round(REST_SECONDS / max(times[1] - times[0], 1e-9))) if len(times) > 1 else 2
    for first in range(0, end - width, max(1, width // 4)):
        part = slice(first, first + width)
        tips = position[part][fresh[part]]
        if len(tips) < width // 2:
            continue
        same = bool(np.all(armed[part] == armed[first]))
        held = not armed[first] or float(np.ptp(command[part], axis=0).max()) < 1e-5
        if same and held and float(np.std(tips, axis=0).max()) < still:
            return first
    return None


def _ages(arrays: Arrays, name: str) -> Array | None:
    """Compute each message's age when its cycle began [s], by both sides' stamps; NaN without one.

    Up to a constant: the two clocks' zeros differ.
    """
    stamps = arrays.arrays.get(f"{name}.stamp_ns")
    if stamps is None:
        return None
    began = np.asarray(arrays[LOG_TIME] - arrays[LOG_TIME][0], dtype=float) * 1e-9
    if "timing.work_us" in arrays.arrays:
        began = began - 1e-6 * np.asarray(arrays["timing.work_us"] + arrays["timing.lateness_us"], dtype=float)
    stamps = np.asarray(stamps, dtype=float) * 1e-9
    return np.asarray(began - stamps)


def _jitter(arrays: Arrays, rows: NDArray[np.intp]) -> Array:
    """Compute the excess of each pose's age over the median [s]; zeros where there are no usable stamps."""
    ages = _ages(arrays, "inputs.pose")
    if ages is None:
        return np.zeros(len(rows))
    ages = ages[rows]
    usual = float(np.nanmedian(ages))
    jitter = np.nan_to_num(ages - usual)
    if float(np.percentile(np.abs(jitter), 95)) > STRANGE_AGE:
        return np.zeros(len(rows))
    return np.clip(jitter, -STRANGE_AGE, STRANGE_AGE)


def _reports(arrays: Arrays, times: Array, part: slice) -> tuple[Array, Array, Array]:
    """Return times, displacements and tensions of the servos' reports in a part of the log.

    A report is as old as its stamp says where tips and tendons are stamped by one clock, and new otherwise.
    """
    n = np.atleast_2d(arrays["command.displacement"]).shape[1]
    found: Any = arrays.arrays.get("inputs.tendon_state.displacement")
    if found is None:
        return np.zeros(0), np.zeros((0, n)), np.zeros((0, n))
    rows = np.arange(len(arrays))[part]
    rows = rows[np.isfinite(found[rows, 0])]
    tensions: Any = arrays["inputs.tendon_state.tension"]
    at, tendons = times[rows], _ages(arrays, "inputs.tendon_state")
    if tendons is not None and rows.size:
        shortest = float(np.nanmin(tendons))  # the freshest report is treated as new
        late = np.nan_to_num(tendons[rows] - shortest)
        if float(np.percentile(late, 95)) < STRANGE_AGE:
            at = at - np.clip(late, 0.0, STRANGE_AGE)
    at, order = np.unique(at, return_index=True)
    return at, found[rows][order], tensions[rows][order]
