"""Directions of the strain in an interval, side by side: each component with modes, at each of two Gauss points.

The lane 2 s + p is that of the component in the slot s at the point p; lanes are done in groups of eight.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined
from tendond.model.numerics.parked import park
from tendond.model.numerics.products import BLOCK, HALF
from tendond.model.numerics.simd import simd_load, simd_multiply_add
from tendond.model.strain.layout import Layout

Array = NDArray[np.float64]
Index = NDArray[np.int64]

DIRECTIONS = 2 * HALF
"""Twelve of them are used at most."""


class Directions(NamedTuple):
    """Directions of each interval.

    Attributes:
        groups: of eight lanes that are used, shape (K,). slot: of each mode's component, shape (n,).
        base: where the unit strains of an interval begin in `unit`, shape (K,).
        unit: unit strains in every lane, at the first Gauss point, then at the second; 0 in the lanes of the other one.
        lanes: six rows of DIRECTIONS, room for a twist in every direction.
        begin: first mode of the first block of eight of an interval, shape (K,). start: of its weights, shape (K,).
        weights: values of the modes in each lane, rows of eight for each lane in use and each block of modes.
        low, high: lanes that a block of eight modes has weights in, as a range, shape (K, N / 8).
    """

    groups: Index
    slot: Index
    base: Index
    unit: Array
    lanes: Array
    begin: Index
    start: Index
    weights: Array
    low: Index
    high: Index


def directions_of(layout: Layout) -> Directions:
    """Return the directions of this robot."""
    intervals, n = layout.at1.shape
    groups, base = np.zeros(intervals, dtype=np.int64), np.zeros(intervals, dtype=np.int64)
    slot = np.zeros(n, dtype=np.int64)
    patterns: dict[tuple[int, ...], int] = {}
    units: list[Array] = []
    for k in range(intervals):
        modes = slice(layout.first[k], layout.last[k])
        used = tuple(int(c) for c in np.unique(layout.component[modes]))
        slot[modes] = np.searchsorted(used, layout.component[modes])
        groups[k] = -(-2 * len(used) // HALF)
        if used not in patterns:
            patterns[used] = len(patterns)
            unit = np.zeros((2, 6, DIRECTIONS))
            for place, component in enumerate(used):
                for point in range(2):
                    unit[point, component, 2 * place + point] = 1.0
            units.append(unit)
        base[k] = patterns[used] * 2 * 6 * DIRECTIONS
    begin = layout.first // HALF * HALF
    sizes = groups * HALF * -(-(layout.last - begin) // HALF) * HALF
    start = np.concatenate(([0], np.cumsum(sizes)))
    weights = np.zeros(start[-1])
    low = np.zeros((intervals, -(-n // HALF)), dtype=np.int64)
    high = low.copy()
    for k in range(intervals):
        rows = weights[start[k] : start[k + 1]].reshape(-1, groups[k] * HALF, HALF)
        for mode in range(layout.first[k], layout.last[k]):
            block, column = divmod(mode - begin[k], HALF)
            lane, place = 2 * slot[mode], mode // HALF
            low[k, place] = min(low[k, place], lane) if high[k, place] else lane
            high[k, place] = max(high[k, place], lane + 2)
            for point, values in enumerate((layout.at1, layout.at2)):
                rows[block, 2 * slot[mode] + point, column] = values[k, mode]
    directions = Directions(
        groups, slot, base, np.array(units).reshape(-1), np.zeros(6 * DIRECTIONS), begin, start[:-1].copy(), weights,
        low, high,
    )  # fmt: skip
    return park(directions)


@inlined
def by_modes(directions: Directions, k: int, rows: Any, row: int, block: int) -> Any:
    """Return a number that is known in each lane by eight modes of an interval, of which `block` is the first."""
    weights, low = directions.weights, directions.low[k, block // HALF]
    here, at = row * DIRECTIONS, _weights_at(directions, k, block)
    value = rows[here + low] * simd_load(weights, at + low * HALF, BLOCK)
    other = rows[here + low + 1] * simd_load(weights, at + (low + 1) * HALF, BLOCK)
    for lane in range(low + 2, directions.high[k, block // HALF], 2):
        value = simd_multiply_add(rows[here + lane], simd_load(weights, at + lane * HALF, BLOCK), value)
        other = simd_multiply_add(rows[here + lane + 1], simd_load(weights, at + (lane + 1) * HALF, BLOCK), other)
    return value + other


@inlined
def vector_by_modes(directions: Directions, k: int, rows: Any, row: int, block: int) -> Any:
    """Return three numbers that are known in each lane, rows from `row` on, by eight modes of an interval."""
    weights, low = directions.weights, directions.low[k, block // HALF]
    here, at = row * DIRECTIONS, _weights_at(directions, k, block)
    weight = simd_load(weights, at + low * HALF, BLOCK)
    x, y = rows[here + low] * weight, rows[here + DIRECTIONS + low] * weight
    z = rows[here + 2 * DIRECTIONS + low] * weight
    for lane in range(low + 1, directions.high[k, block // HALF]):
        weight = simd_load(weights, at + lane * HALF, BLOCK)
        x = simd_multiply_add(rows[here + lane], weight, x)
        y = simd_multiply_add(rows[here + DIRECTIONS + lane], weight, y)
        z = simd_multiply_add(rows[here + 2 * DIRECTIONS + lane], weight, z)
    return x, y, z


@inlined
def _weights_at(directions: Directions, k: int, block: int) -> int:
    """Return where the weights of a block of eight modes begin."""
    begin: int = directions.start[k] + (block - directions.begin[k]) * directions.groups[k] * HALF
    return begin
