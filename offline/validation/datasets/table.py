"""A lab's own poses: a CSV file of the tendons' displacements and the tip, in the order of the sequence."""

import csv
import math
from pathlib import Path

import numpy as np

from tendond.offline.validation.datasets.poses import DatasetError, Poses, held_out_blocks

COLUMNS = "displacement_0, displacement_1, ... and x, y, z, all in metres; optionally block (a whole number)"
BLOCKS = 20
"""Parts of a sequence that names none."""


def read(path: Path) -> Poses:
    """Read a CSV file of static poses.

    Columns, in any order: `displacement_0` to `displacement_m`, the shortening of each tendon that the servos
    commanded [m], positive where it is pulled; `x`, `y`, `z`, the tip [m] in the camera's frame; optionally `block`,
    the number of the part of the sequence. Others are ignored. The rows are in the order in which they were measured.

    Raises:
        DatasetError: the file cannot be read, a column is missing, or a cell is not a finite number.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            rows = list(csv.DictReader(stream))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise DatasetError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from error
    heading = set(rows[0]) if rows else set()
    count = 0
    while f"displacement_{count}" in heading:
        count += 1
    if not count or not {"x", "y", "z"} <= heading:
        raise DatasetError(f"{path}: a column is missing; it needs {COLUMNS}")
    names = [f"displacement_{i}" for i in range(count)] + ["x", "y", "z"]
    numbers = np.empty((len(rows), count + 3))
    block = np.arange(len(rows)) * BLOCKS // len(rows)
    for index, row in enumerate(rows):
        for column, name in enumerate(names):
            try:
                numbers[index, column] = float(row[name])
            except (TypeError, ValueError):
                raise DatasetError(f"{path}:{index + 2}: {name} = '{row[name]}' is not a number") from None
            if not math.isfinite(numbers[index, column]):
                raise DatasetError(f"{path}:{index + 2}: {name} = '{row[name]}' is not finite: leave out that pose")
        if "block" in heading:
            try:
                block[index] = int(row["block"])
            except (TypeError, ValueError):
                raise DatasetError(f"{path}:{index + 2}: block = '{row['block']}' is not a whole number") from None
    if np.any(np.diff(block) < 0):
        raise DatasetError(f"{path}: the blocks must be in the order of the sequence")
    _, block = np.unique(block, return_inverse=True)
    labels = tuple(f"block {index}" for index in range(int(block.max()) + 1))
    tip = numbers[:, count:]
    return Poses(path.stem, str(path), numbers[:, :count], tip, block, labels, held_out_blocks(block))
