"""A sequence of measured static poses: the tendons' commands, and where the tip came to rest."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tendond import TendondError

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Index = NDArray[np.int64]


class DatasetError(TendondError):
    """A data set that is missing or cannot be read: what, where, and where to get it."""


@dataclass(frozen=True)
class Poses:
    """Measured static poses, in the order in which they were taken: friction remembers it.

    Attributes:
        name: of the data set. source: who measured it, licence, citation.
        command: displacement of each tendon [m], positive where it is pulled, shape (N, m).
        tip: measured position [m], the camera's frame, shape (N, 3).
        block: number of the part of the sequence that a pose belongs to, ascending, shape (N,); held out whole.
        label: a name of each block. held_out: poses that are never fitted, shape (N,).
    """

    name: str
    source: str
    command: Array
    tip: Array
    block: Index
    label: tuple[str, ...]
    held_out: Mask

    def __post_init__(self) -> None:
        count = len(self.command)
        if np.shape(self.tip) != (count, 3) or np.shape(self.block) != (count,) or np.shape(self.held_out) != (count,):
            raise DatasetError(f"{self.name}: commands, tips, blocks and held-out marks must be of one length")
        if not (np.all(np.isfinite(self.command)) and np.all(np.isfinite(self.tip))):
            raise DatasetError(f"{self.name}: a command or a tip is not finite: remove the row")
        if not self.held_out.any() or self.held_out.all():
            raise DatasetError(f"{self.name}: {count} poses in {len(self.label)} blocks: too few to hold a part out")
        mixed = [int(one) for one in np.unique(self.block[self.held_out]) if not self.held_out[self.block == one].all()]
        if mixed:
            raise DatasetError(f"{self.name}: block {mixed[0]} is held out in part only")

    def __len__(self) -> int:
        return len(self.command)

    @property
    def tendons(self) -> int:
        """Number of tendons, m."""
        return int(self.command.shape[1])

    def part(self, keep: Mask | Index) -> "Poses":
        """Return some of the poses, in the same order."""
        chosen = (self.command[keep], self.tip[keep], self.block[keep], self.held_out[keep])
        return replace(self, command=chosen[0], tip=chosen[1], block=chosen[2], held_out=chosen[3])


def held_out_blocks(block: Index, every: int = 5) -> Mask:
    """Hold out every `every`th block, from the middle of the first `every` on, shape (N,)."""
    return np.asarray(block % every == every // 2)


def split_evenly(poses: Poses, every: int) -> Poses:
    """Return the poses with every `every`th block held out instead of those that the data set holds out.

    Raises:
        DatasetError: too few blocks.
    """
    return replace(poses, name=f"{poses.name}-every{every}", held_out=held_out_blocks(poses.block, every))


SWING = 0.05
"""Part of a command's range by which it must go back to have turned round: more than a servo's reading scatters."""


def turning_points(command: Array) -> Mask:
    """Mark the poses at which some tendon's command turns round, and the first and the last one, shape (N,).

    A play operator that sees only these, and some in between, has the same state at them as one that sees all.
    """
    keep = np.zeros(len(command), dtype=np.bool_)
    keep[[0, -1]] = True
    for column in command.T:
        swing, top, direction = SWING * float(np.ptp(column)), 0, 1.0
        for i, value in enumerate(column):
            if direction * (value - column[top]) >= 0.0:
                top = i
            elif direction * (column[top] - value) > swing:
                keep[top] = True
                top, direction = i, -direction
    return keep


def thinned(poses: Poses, count: int, turning: bool = True) -> Poses:
    """Return about `count` poses, evenly spread, and, for models with memory, all turning points of the commands."""
    keep = turning_points(poses.command) if turning else np.zeros(len(poses), dtype=np.bool_)
    step = max(1, round(len(poses) / count))
    keep[np.arange(len(poses)) % step == (np.arange(len(poses)) // step) % step] = True
    return poses.part(keep)
