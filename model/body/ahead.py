"""The motion of a body's points by the derivatives of one step, continued far ahead, in one kernel.

With x = (q, w) now and x + f the step that comes, by its derivatives A and B, and y(i) the change of x after i steps,

    y(i+1) = A y(i) + B u(i) + f,    u(i) = (1 - l^(i+1)) u

under tensions that change by u for good, with actuators of lag factor l. Powers of the augmented matrix by squaring
reach any time in a few products.
"""

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import kernel, lean

Array = NDArray[np.float64]


@lean
def _add_product(left: Array, right: Array, rows: int, out: Array) -> None:
    """Add left times right to out, for the first rows of left; four rows of right at a time stay in registers."""
    size = len(right)
    whole = size - size % 4
    for i in range(rows):
        for k in range(0, whole, 4):
            a, b, c, d = left[i, k], left[i, k + 1], left[i, k + 2], left[i, k + 3]
            for j in range(size):
                out[i, j] += a * right[k, j] + b * right[k + 1, j] + c * right[k + 2, j] + d * right[k + 3, j]
        for k in range(whole, size):
            for j in range(size):
                out[i, j] += left[i, k] * right[k, j]


@lean
def _double(power: Array, offset: Array, other: Array, moved: Array) -> None:
    """Let power and offset stand for twice the time: P P, and P o + o. All are transposed: rows are columns."""
    _copy(offset, moved)
    _add_product(moved, power, len(offset), offset)
    for i in range(len(power)):
        for j in range(len(power)):
            other[i, j] = 0.0
    _add_product(power, power, len(power), other)
    _copy(other, power)


@lean
def _copy(source: Array, out: Array) -> None:
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            out[i, j] = source[i, j]


@kernel
def look_ahead(
    a: Array, b: Array, coming: Array, lag: float, doublings: int, each: int, later: int, points: Array, bends: Array,
    moves: Array, turns: Array,
) -> bool:  # fmt: skip
    """Write moves of points and changes of bends at samples of the motion: without a change of the tensions, and by it.

    Returns whether they are finite: unstable derivatives grow beyond all numbers.

    Args:
        a, b: derivatives of the step by strains and rates before it, shape (2 n, 2 n), and by tensions, shape (2 n, m).
        coming: change of strains and rates in the step, shape (2 n,). lag: of the actuators over it [-].
        doublings: the first `each` samples are 2^doublings steps apart; the `later` ones are twice as late each.
        points: by the strains, shape (P, n). bends: by the strains, shape (b, n).
        moves: of the points, shape (k, P, 1 + m). turns: of the bends, shape (k, b, 1 + m). k = each + later.
    """
    double, columns = len(a), 1 + b.shape[1]
    n, size = double // 2, double + (columns - 1 if lag > 0.0 else 0)
    power, other = np.zeros((size, size)), np.zeros((size, size))
    offset, moved = np.zeros((columns, size)), np.zeros((columns, size))
    now = np.zeros((columns, size))
    for i in range(double):
        offset[0, i] = coming[i]
        for j in range(double):
            power[j, i] = a[i, j]
        for c in range(1, columns):
            offset[c, i] = b[i, c - 1]
    if lag > 0.0:
        for c in range(1, columns):
            for i in range(double):
                power[double + c - 1, i] = -b[i, c - 1]
            power[double + c - 1, double + c - 1] = lag
            now[c, double + c - 1] = lag
    for _ in range(doublings):
        _double(power, offset, other, moved)
    for k in range(each + later):
        if k == each:
            for _ in range(int(np.log2(max(each, 1)))):
                _double(power, offset, other, moved)
        elif k > each:
            _double(power, offset, other, moved)
        _copy(offset, moved)
        _add_product(now, power, columns, moved)
        _copy(moved, now)
        for c in range(columns):
            _project(points, now[c], n, moves[k], c)
            _project(bends, now[c], n, turns[k], c)
    total = 0.0
    for c in range(columns):  # what has become infinite stays so
        for i in range(size):
            total += abs(now[c, i])
    return bool(np.isfinite(total))


@lean
def _project(rows: Array, values: Array, n: int, out: Array, column: int) -> None:
    """Write products of rows with the first n values into a column."""
    for i in range(len(rows)):
        total = 0.0
        for j in range(n):
            total += rows[i, j] * values[j]
        out[i, column] = total
