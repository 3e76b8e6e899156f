"""The Continuum Robotics Laboratory's arms ftdcr_v4 and ftdcr_v6: three sections, nine tendons, motion capture."""

import csv
from pathlib import Path

import numpy as np

from tendond.offline.validation.datasets.poses import Array, DatasetError, Poses

SOURCE = "github.com/ContinuumRoboticsLab/opencr-mujoco @17fff8b (MIT), data/reference/{version}; arXiv 2606.22397"
TENDONS = 9
HOLD = "_hold"
PULL_EVERY = 3
"""One in so many blocks of the single pulls is held out."""

PULL_BLOCK = 4
"""Poses of a block of the single pulls, which has some 14 a tendon: a quarter of a pull and release."""


def read(folder: Path, version: str, part: str) -> Poses:
    """Read an arm's poses from `opencr-mujoco/ftdcr_v4` or `ftdcr_v6` in a folder of reference data.

    Args:
        folder: of reference data.
        version: "ftdcr_v4" or "ftdcr_v6".
        part: "val": all poses, of which the authors' validation file is held out. "tendon_pull": those with one tendon
            pulled and the others slack; every third block of four poses is held out.

    Raises:
        DatasetError: a file is not there, or is not as the authors wrote it.
    """
    base = folder / "opencr-mujoco" / version
    source = SOURCE.format(version=version)
    name = f"{version}-{part}"
    if part == "tendon_pull":
        command, tip, labels, _ = _rows(base, "tendon_pull", source)
        starts = _starts(labels)
        block = np.cumsum([int(index == start or (index - start) % PULL_BLOCK == 0) for index, start in starts]) - 1
        held_out = np.asarray(block % PULL_EVERY == 1)
        names = tuple(labels[int(np.flatnonzero(block == one)[0])] for one in range(int(block[-1]) + 1))
        return Poses(name, source, command, tip, block, names, held_out)
    command, tip, labels, times = _rows(base, "keypoints", source)
    _, _, _, held_times = _rows(base, "val", source)
    starts = _starts(labels)
    block = np.cumsum([int(index == start) for index, start in starts]) - 1
    names = tuple(labels[int(np.flatnonzero(block == one)[0])] for one in range(int(block[-1]) + 1))
    later = set(held_times)
    held = np.array([time in later for time in times])
    held_out = np.array([held[block == one].any() for one in block])
    return Poses(name, source, command, tip, block, names, held_out)


def _starts(labels: list[str]) -> list[tuple[int, int]]:
    """Return each pose's number, and that of the first pose of its pattern."""
    found, start = [], 0
    for index, label in enumerate(labels):
        start = index if index and label != labels[index - 1] else start
        found.append((index, start))
    return found


def _rows(base: Path, kind: str, source: str) -> tuple[Array, Array, list[str], list[str]]:
    """Read commands [m], tips [m], patterns and times of one of the files."""
    files = sorted(base.glob(f"*_{kind}.csv"))
    if not files:
        raise DatasetError(f"{base}: holds no *_{kind}.csv; get it from {source}")
    with files[-1].open(encoding="utf-8", newline="") as stream:
        lines = list(csv.reader(stream))
    if len(lines) < 2 or len(lines[0]) != TENDONS + 5:
        raise DatasetError(f"{files[-1]}: the heading must have time, label, {TENDONS} servos and the tip's x, y, z")
    try:
        numbers = np.array([[float(cell) for cell in line[2:]] for line in lines[1:]])
    except ValueError as error:
        raise DatasetError(f"{files[-1]}: {error}") from None
    labels = [line[1].removesuffix(HOLD) for line in lines[1:]]
    return numbers[:, :TENDONS] * 1e-3, numbers[:, TENDONS:] * 1e-3, labels, [line[0] for line in lines[1:]]
