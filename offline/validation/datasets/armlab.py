"""ARM-Lab's robot: one section hanging from its base, three tendons, 30 000 static tips by motion capture."""

from pathlib import Path

import numpy as np

from tendond.offline.validation.datasets.poses import DatasetError, Poses, held_out_blocks

NAME = "armlab"
FILE = "armlab-single-section/Dataset.txt"
SOURCE = (
    "github.com/ARM-Lab/Learning-Based-Position-Control-for-Continuum-Robots @00b2d76 (MIT), Dataset.txt; "
    "doi 10.1109/PC65047.2025.11047513"
)
BLOCK = 1000
"""Poses of a block: ten sweeps of the inner tendon, over 1 mm of the outer one's command."""


def read(folder: Path) -> Poses:
    """Read `armlab-single-section/Dataset.txt` in a folder of reference data.

    A line is a1, a2, a3 [0.1 mm], x, y, z [mm].

    Raises:
        DatasetError: the file is not there, or a line is not six numbers.
    """
    path = folder / FILE
    if not path.is_file():
        raise DatasetError(f"{path}: is not there; get it from {SOURCE}")
    try:
        rows = np.loadtxt(path, delimiter=",", ndmin=2)
    except ValueError as error:
        raise DatasetError(f"{path}: {error}; each line is a1,a2,a3,x,y,z") from None
    if rows.shape[1] != 6:
        raise DatasetError(f"{path}: {rows.shape[1]} columns; each line is a1,a2,a3,x,y,z")
    block = np.arange(len(rows)) // min(BLOCK, max(1, len(rows) // 10))
    labels = tuple(f"block {index}" for index in range(int(block[-1]) + 1))
    return Poses(NAME, SOURCE, rows[:, :3] * 1e-4, rows[:, 3:] * 1e-3, block, labels, held_out_blocks(block))
