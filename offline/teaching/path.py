"""A path that was shown: measured poses, smoothed, at rest at both ends, written as a reference's file."""

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d

from tendond.daemon.errors import DaemonError, UsageError
from tendond.offline.files import whole
from tendond.schemas.messages import TipPose

Array = NDArray[np.float64]

Columns = Literal["direction", "position", "xz", "yz"]
"""What is written beside the time: position and direction; the position; or the position in the bending plane."""

HEADINGS: dict[Columns, tuple[str, ...]] = {
    "direction": ("x [m]", "y [m]", "z [m]", "dx [-]", "dy [-]", "dz [-]"),
    "position": ("x [m]", "y [m]", "z [m]"),
    "xz": ("x [m]", "z [m]"),
    "yz": ("y [m]", "z [m]"),
}

FINE, RATE = 100.0, 10.0
"""Samples a second that are smoothed, and that are written. Chosen: a hand moves an arm at 2 Hz at most."""

GAP = 0.5
"""Longest time without a valid pose that is bridged [s]. Chosen."""

STILL = 2e-3
"""Distance from the first and the last pose within which the arm counts as not yet, or no longer, moved [m]: twenty
times a camera's noise. Chosen."""

SHORTEST = 0.3
"""Duration below which nothing was shown [s]. Chosen."""


@dataclass(frozen=True)
class Shown:
    """Measured poses, in order.

    Attributes:
        time: [s], shape (k,). position: [m], shape (k, 3). direction: of the tip [-], shape (k, 3).
    """

    time: Array
    position: Array
    direction: Array


def shown(poses: list[tuple[float, TipPose]]) -> Shown:
    """Return the valid poses of a recording of times [s] and poses, each measurement once.

    Raises:
        UsageError: there are fewer than ten.
    """
    kept: list[tuple[float, TipPose]] = []
    for time, pose in poses:
        if pose.valid and (not kept or (pose.seq != kept[-1][1].seq and time > kept[-1][0])):
            kept.append((time, pose))
    if len(kept) < 10:
        raise UsageError(f"only {len(kept)} valid poses were recorded, and a path needs ten: check the camera")
    turns = np.array([pose.orientation for _, pose in kept])
    w, x, y, z = turns.T
    direction = np.column_stack((2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)))
    return Shown(np.array([time for time, _ in kept]), np.array([pose.position for _, pose in kept]), direction)


def smoothed(given: Shown, smoothing: float, *, trim: bool = True) -> Array:
    """Return rows of time [s], position [m] and direction [-] from rest to rest, shape (k, 7).

    A Gaussian filter of zero phase in time; stillness before and after the motion is left out.

    Args:
        given: measured poses.
        smoothing: standard deviation of the filter [s].
        trim: leave out stillness.

    Raises:
        UsageError: a gap is too long to be bridged, or nothing moved.
    """
    gaps = np.diff(given.time)
    if float(gaps.max()) > GAP:
        at = float(given.time[int(np.argmax(gaps))] - given.time[0])
        raise UsageError(
            f"no valid pose for {gaps.max():.2f} s, {at:.2f} s after the first, where {GAP:g} s can be bridged: record "
            "again, with the markers in view"
        )
    first, last = _moving(given) if trim else (given.time[0], given.time[-1])
    if last - first < SHORTEST:
        raise UsageError(f"the tip has not moved by {STILL * 1e3:g} mm: move the arm while recording")
    time = np.linspace(first, last, max(int((last - first) * FINE), 16) + 1)
    columns = np.column_stack((given.position, given.direction))
    dense = np.column_stack([np.interp(time, given.time, column) for column in columns.T])
    width = smoothing / float(time[1] - time[0])
    if width > 0.0:
        dense = gaussian_filter1d(dense, width, axis=0, mode="nearest")
    dense[:, 3:] /= np.linalg.norm(dense[:, 3:], axis=1)[:, None]
    spline = CubicSpline(time - time[0], dense, bc_type="clamped")
    end = float(time[-1] - time[0])
    at_rows = np.linspace(0.0, end, max(int(end * RATE), 4) + 1)
    rows = np.column_stack((at_rows, spline(at_rows)))
    rows[:, 4:] /= np.linalg.norm(rows[:, 4:], axis=1)[:, None]
    return rows


def _moving(given: Shown) -> tuple[float, float]:
    """Return the time before the tip leaves its first place, and the time after it arrives at its last [s]."""
    away = np.linalg.norm(given.position - given.position[0], axis=1) > STILL
    coming = np.linalg.norm(given.position - given.position[-1], axis=1) > STILL
    if not away.any() or not coming.any():
        return float(given.time[0]), float(given.time[0])
    begin = max(int(np.argmax(away)) - 1, 0)
    end = min(len(coming) - int(np.argmax(coming[::-1])), len(coming) - 1)
    return float(given.time[begin]), float(given.time[end])


def write_path(rows: Array, columns: Columns, path: Path) -> int:
    """Write a reference's file, with units in its header; return the number of rows.

    Args:
        rows: of `smoothed`. columns: to write beside the time. path: the file.

    Raises:
        DaemonError: it cannot be written.
    """
    picked = {"direction": (0, 1, 2, 3, 4, 5, 6), "position": (0, 1, 2, 3), "xz": (0, 1, 3), "yz": (0, 2, 3)}[columns]
    try:
        with whole(path) as draft, draft.open("w", encoding="utf-8", newline="") as stream:
            writer = csv.writer(stream)
            writer.writerow(("time [s]", *HEADINGS[columns]))
            for row in rows[:, picked].tolist():
                writer.writerow([f"{value:.7g}" for value in row])
    except OSError as error:
        raise DaemonError(f"{path}: cannot be written: {error.strerror}; choose another file with --out") from error
    return len(rows)
