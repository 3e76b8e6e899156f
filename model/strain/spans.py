"""Sections of a robot as the kernels see them: where their intervals, mass points and modes begin.

Modes of a section act on its own nodes and on all beyond, which they move as one rigid body. What is summed up over
nodes is therefore full only for a section's own modes; those of the sections before count by what all nodes beyond add
up to, with the twists of the node where the section begins.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.parked import park
from tendond.model.numerics.products import HALF, padded
from tendond.model.strain.layout import Index, Layout

Array = NDArray[np.float64]


class Spans(NamedTuple):
    """Sections of a robot, S of them.

    Attributes:
        node: at which a section begins, then the last one, shape (S + 1,). point: first mass point of a section, then
            their number, shape (S + 1,).
        first, last: modes of a section, as a range, shape (S,). block: first mode of its first block of eight.
        own: 1 in the lanes of a section's modes, else 0, a row of N each, in a row.
        width: of rows for the modes of one section, shape (1,).
    """

    node: Index
    point: Index
    first: Index
    last: Index
    block: Index
    own: Array
    width: Index


def spans_of(layout: Layout) -> Spans:
    """Return the sections of this robot."""
    starts = np.flatnonzero(np.concatenate(([True], layout.first[1:] != layout.first[:-1])))
    first, last, block = layout.first[starts], layout.last[starts], layout.first[starts] // HALF * HALF
    node = np.append(starts, len(layout.step))
    lanes = -(-len(layout.component) // HALF) * HALF
    own = np.zeros((len(starts), lanes))
    for row, begin, end in zip(own, first, last, strict=True):
        row[begin:end] = 1.0
    spans = Spans(
        node.astype(np.int64), np.searchsorted(layout.place, node + 1).astype(np.int64), first, last, block,
        own.reshape(-1), np.array([padded.py_func(int(np.max(last - block)))]),
    )  # fmt: skip
    return park(spans)
