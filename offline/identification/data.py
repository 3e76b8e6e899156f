"""What a log says that a fit can use: commands, reports of the servos, poses, all on one time axis."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.errors import DaemonError, UsageError
from tendond.offline.logs.arrays import LOG_TIME, Arrays, load
from tendond.offline.logs.log import as_text
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode

Array = NDArray[np.float64]

WEIGHT_NOTE = "weight"
"""Name in a log's metadata of the known weight on its tip [kg]."""

REST_SECONDS = 0.3
"""That the arm must stand still before a motion, for its state to be known."""

STILL = 3e-4
"""[m] Spread of the tip's position that counts as rest, or three times the noise where that is more."""

STRANGE_AGE = 0.5
"""[s] Ages of poses that scatter by more are not believed: publisher and controller have different clocks."""


class DataError(DaemonError):
    """A log that a fit cannot use, and why."""


@dataclass(frozen=True)
class Recording:
    """A log from a rest of the arm on, as a fit takes it; times in seconds from that rest's beginning.

    Attributes:
        path: of the log.
        config: of the rig when it was recorded.
        weight: known mass fixed to the tip, beside the rod's own tip_mass [kg]; zero: none.
        period: of the cycle [s].
        times: at which each cycle's command was given, shape (k,).
        armed: of each command, shape (k,).
        command: displacements [m], shape (k, n).
        report_times: of the servos' reports, shape (r,); reported: displacements [m], pulled: tensions [N], (r, n).
        pose_times: at which each pose arrived, less what its age differs from the usual one, shape (m,).
        position: of the tip, measured [m], shape (m, 3).
        noise: of a coordinate [m], from differences of the poses.
        cycles: in the whole log. hidden: of these, without a pose that could be used.
        limited: part of the armed cycles in which the command stood at a limit. missed: deadlines.
        fault: in which the log ended, in words.
    """

    path: Path
    config: RigConfig
    weight: float
    period: float
    times: Array
    armed: NDArray[np.bool_]
    command: Array
    report_times: Array
    reported: Array
    pulled: Array
    pose_times: Array
    position: Array
    noise: float
    cycles: int
    hidden: int
    limited: float
    missed: int
    fault: str

    @property
    def name(self) -> str:
        """Of the file, for tables."""
        return as_text(self.path.name)

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.times[-1])

    @property
    def has_reports(self) -> bool:
        """Whether the servos reported in nearly all cycles in which they were armed."""
        return len(self.report_times) > 0.9 * len(self.times)


def load_recording(path: Path, weights: Mapping[str, float]) -> Recording:
    """Read a log.

    Args:
        path: of the log.
        weights: on the tip [kg], by path or file name; they go before what the log says itself.

    Raises:
        LogError: it cannot be read.
        DataError: it has no poses, or no rest from which the motion could be computed.
    """
    arrays = load(path)
    period = arrays.config.loop.period
    missed = np.cumsum(arrays["inputs.missed_ticks"])
    cycle = (arrays["tick"] - arrays["tick"][0] + missed) * period
    seen = _fresh(arrays)
    if not np.any(seen):
        raise DataError(f"{path}: has no pose of the tip that the controller accepted: nothing to fit to")
    noise = _noise(arrays["measured"][seen])
    modes = arrays["mode"]
    faults = np.flatnonzero(modes == Mode.FAULT.value)
    end = int(faults[0]) if faults.size else len(arrays)
    fault = str(arrays["reason"][end]) if faults.size else ""
    command = np.atleast_2d(arrays["command.displacement"])
    armed = arrays["command.armed"].astype(bool)
    first = _first_rest(cycle, command, armed, seen, arrays["measured"], max(STILL, 3.0 * noise), end)
    if first is None:
        raise DataError(
            f"{path}: the arm never stands still for {REST_SECONDS:g} s before it moves, so the state that a motion "
            "starts from is not known: record a rest first"
        )
    part = slice(first, end)
    origin = cycle[first]
    rows = np.flatnonzero(seen[part]) + first
    limited = arrays["limited"][part] != ""
    reports = _reports(arrays, cycle, part)
    return Recording(
        path=path,
        config=arrays.config,
        weight=_weight(arrays, path, weights),
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
        hidden=int(len(arrays) - np.count_nonzero(seen)),
        limited=float(np.mean(limited[armed[part]])) if np.any(armed[part]) else 0.0,
        missed=int(missed[-1]),
        fault=fault,
    )


def _weight(arrays: Arrays, path: Path, weights: Mapping[str, float]) -> float:
    for name in (str(path), path.name):
        if name in weights:
            return weights[name]
    text = arrays.metadata.get(WEIGHT_NOTE)
    if text is None:
        return 0.0
    try:
        return parse_weight(text)
    except ValueError:
        raise DataError(f"{path}: says that its weight is '{text}', which is none: give --weight") from None


def parse_weight(text: str) -> float:
    """A weight [kg].

    Raises:
        ValueError: it is none.
    """
    value = float(text)
    if not 0.0 <= value <= 10.0:
        raise ValueError
    return value


def parse_weights(options: list[str]) -> dict[str, float]:
    """`--weight LOG=KG`, by log.

    Raises:
        UsageError: one that is not of that form.
    """
    weights = {}
    for option in options:
        name, sign, text = option.rpartition("=")
        try:
            weights[name] = parse_weight(text)
        except ValueError:
            sign = ""
        if not sign or not name:
            raise UsageError(f"--weight {option}: give LOG=KG with 0 to 10 kg, for instance --weight loaded.mcap=0.05")
    return weights


def _fresh(arrays: Arrays) -> NDArray[np.bool_]:
    """Cycles in which a new pose was taken over."""
    return np.asarray(np.asarray(arrays.arrays.get("pose_age", np.full(len(arrays), np.nan)), dtype=float) == 0.0)


def _noise(position: Array) -> float:
    """Of a coordinate [m], from third differences, which a smooth motion hardly has: their median is that of noise."""
    if len(position) < 8:
        return 0.0
    third = np.diff(position, 3, axis=0)
    return float(np.median(np.abs(third)) / 0.6745 / math.sqrt(20.0))


def _first_rest(
    times: Array,
    command: Array,
    armed: NDArray[np.bool_],
    seen: NDArray[np.bool_],
    position: Array,
    still: float,
    end: int,
) -> int | None:
    """First cycle of the first rest."""
    width = max(2, round(REST_SECONDS / max(times[1] - times[0], 1e-9))) if len(times) > 1 else 2
    for first in range(0, end - width, max(1, width // 4)):
        part = slice(first, first + width)
        tips = position[part][seen[part]]
        if len(tips) < width // 2:
            continue
        same = bool(np.all(armed[part] == armed[first]))
        held = not armed[first] or float(np.ptp(command[part], axis=0).max()) < 1e-5
        if same and held and float(np.std(tips, axis=0).max()) < still:
            return first
    return None


def _ages(arrays: Arrays, name: str) -> Array | None:
    """Age of each cycle's message when the cycle began [s], by the stamps of publisher and recorder; NaN without one.

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
    """By how much each pose is older than usual when it arrives [s]; zeros where the stamps say nothing."""
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
    """Times, displacements and tensions of the servos' reports in a part of the log.

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
        shortest = float(np.nanmin(tendons))  # the freshest report is taken for new
        late = np.nan_to_num(tendons[rows] - shortest)
        if float(np.percentile(late, 95)) < STRANGE_AGE:
            at = at - np.clip(late, 0.0, STRANGE_AGE)
    at, order = np.unique(at, return_index=True)
    return at, found[rows][order], tensions[rows][order]
