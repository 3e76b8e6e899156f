"""Rests of a recording: where the commands are held and the tip is still, and the path of the tendons between them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.offline.identification.recordings.recording import DataError, Drive, Recording
from tendond.offline.validation.datasets.poses import turning_points

Array = NDArray[np.float64]

REST_SECONDS = 0.3
"""Time for which commands and tip are still at a rest [s]."""

HELD = 1e-4
"""Largest change of a command within a rest [m]: a loop that holds a tip moves it by its noise."""

STILL = 4e-4
"""Largest drift of the tip within a rest [m], between the means of its halves, or three times the noise."""

ONLY_RESTS = 0.6
"""Share of the time at rest from which a log counts as one of rests. Derived: `tendond identify plan` rests in 0.1 to
0.35 of its parts, a robot that waits twice as long as it moves in 0.67."""

MIN_RESTS = 4


@dataclass(frozen=True)
class Rests:
    """Rests of a recording, in order of time.

    Attributes:
        times: of their middle [s], shape (k,). position: mean tip [m], shape (k, 3). noise: of a coordinate of it [m].
        pulled: mean reported tensions [N], shape (k, n). path: displacements of the tendons' ends [m] along the whole
            recording: its rests, turning points, and steps between them, shape (q, n).
        armed: where these are pulled, shape (q,). row: index in `path` of each rest, shape (k,).
        share: of the recording that is at rest, of its time.
    """

    times: Array
    position: Array
    noise: float
    pulled: Array
    path: Array
    armed: NDArray[np.bool_]
    row: NDArray[np.int64]
    share: float

    def __len__(self) -> int:
        return len(self.times)


def find_rests(recording: Recording, drive: Drive) -> Rests:
    """Find the rests of a recording; of each the later half counts, so that it has settled.

    Raises:
        DataError: fewer than `MIN_RESTS`.
    """
    spans = _spans(recording)
    if len(spans) < MIN_RESTS:
        raise DataError(
            f"{recording.path}: has {len(spans)} rests of {REST_SECONDS:g} s, and a fit to rests takes {MIN_RESTS} or "
            "more: hold each pull until the tip is still, or fit the motion"
        )
    ends = _ends(recording, drive)
    times, position, pulled, points, rows, counts = [], [], [], [], [], []
    kept = turning_points(np.where(recording.armed[:, None], recording.command, 0.0))
    kept[1:] |= recording.armed[1:] != recording.armed[:-1]
    before = 0
    for first, last in spans:
        middle = (first + last) // 2
        begin, end = recording.times[middle], recording.times[last]
        poses = (recording.pose_times >= begin) & (recording.pose_times <= end)
        reports = (recording.report_times >= begin) & (recording.report_times <= end)
        points += [(bool(recording.armed[k]), ends[k]) for k in range(before, middle) if kept[k]]
        rows.append(len(points))
        points.append((bool(recording.armed[last]), ends[middle : last + 1].mean(axis=0)))
        times.append(0.5 * (begin + end))
        position.append(recording.position[poses].mean(axis=0))
        none = np.zeros(recording.command.shape[1])
        pulled.append(recording.pulled[reports].mean(axis=0) if reports.any() else none)
        counts.append(np.count_nonzero(poses))
        before = last + 1
    noise = recording.noise / float(np.sqrt(np.median(counts)))
    path, armed = np.array([point for _, point in points]), np.array([is_armed for is_armed, _ in points])
    return Rests(
        np.array(times), np.array(position), noise, np.array(pulled), path, armed, np.array(rows),
        _share(recording, spans),
    )  # fmt: skip


def has_only_rests(recording: Recording) -> bool:
    """Check for a recording of a robot that is pulled and waits, again and again."""
    spans = _spans(recording)
    return len(spans) >= MIN_RESTS and _share(recording, spans) >= ONLY_RESTS


def _share(recording: Recording, spans: Sequence[tuple[int, int]]) -> float:
    """Return the share of the time at rest."""
    return float(sum(recording.times[last] - recording.times[first] for first, last in spans) / recording.duration)


def _ends(recording: Recording, drive: Drive) -> Array:
    """Return the tendons' ends at each cycle: the commands, or the servos' reports [m], shape (cycles, n)."""
    if drive == "command" or not len(recording.report_times):
        return recording.command
    columns = recording.reported.T
    return np.column_stack([np.interp(recording.times, recording.report_times, column) for column in columns])


def _spans(recording: Recording) -> list[tuple[int, int]]:
    """Return first and last cycle of each rest."""
    width = max(2, round(REST_SECONDS / recording.period))
    still = max(STILL, 3.0 * recording.noise)
    spans: list[tuple[int, int]] = []
    first, count = 0, len(recording.times)
    while first + width < count:
        last = _held_until(recording, first)
        if last - first < width:
            first = max(last, first + 1)
            continue
        begin = _settled(recording, first, last, width, still)
        if begin is not None:
            spans.append((begin, last))
        first = last + 1
    return spans


def _held_until(recording: Recording, first: int) -> int:
    """Return the last cycle up to which the commands of the first one are held."""
    apart = np.abs(recording.command[first:] - recording.command[first]).max(axis=1)
    changed = (recording.armed[first:] != recording.armed[first]) | ((apart > HELD) & recording.armed[first:])
    return first + (int(np.argmax(changed)) if changed.any() else len(changed)) - 1


def _settled(recording: Recording, first: int, last: int, width: int, still: float) -> int | None:
    """Return the cycle from which the tip stays still until the last one; none if it never does for a rest's time."""
    here = (recording.pose_times >= recording.times[first]) & (recording.pose_times <= recording.times[last])
    times, tips = recording.pose_times[here], recording.position[here]
    end = None
    for begin in range(last - width, first - 1, -max(1, width // 2)):
        part = tips[times >= recording.times[begin]]
        half = len(part) // 2
        if half < 2 or np.abs(part[half:].mean(axis=0) - part[:half].mean(axis=0)).max() > still:
            break
        spread = np.abs(part - part.mean(axis=0)).max()
        if spread > still + 6.0 * recording.noise:
            break
        end = begin
    return end
