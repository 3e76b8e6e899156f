"""The smallest change of a vector that meets a few linear constraints: a strictly convex quadratic program.

    minimise 1/2 |x|^2 + W/2 |s|^2    subject to    G x + s >= b,  low <= x <= high

with unit rows of G, so that s is in the unit of x. The shortfall s keeps it feasible; its weight W makes it negligible
where there is another solution. The dual has bounds only, y >= 0, and is solved by an active set as in Lawson & Hanson,
Solving Least Squares Problems, 1974, chapter 23: rows join where they are violated most, and leave where their
multiplier would become negative.
"""

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import kernel, lean

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

WEIGHT = 1e6
"""Weight of the shortfall, relative to the change itself: a row of multiplier y [N] is missed by y / W [N]. Chosen:
a micronewton for each newton, far below what a servo resolves."""

TOLERANCE = 1e-9
"""Violation below which a row counts as met, relative to the largest b. Chosen: rounding in some ten products."""

CHANGES = 60
"""Largest number of changes of the active set: rows come and go a few times at most. Chosen; a test draws up to 40."""

ROUNDS = 4
"""Linear programs at most: distances are curved, and each adds the rows that its solution missed. Chosen: more than
two are needed only beside a sphere's edge."""

ROWS = 3
"""Constraints that a linear program adds, at one sample each: those missed most."""

SLOPE_MIN = 1e-9
"""Slope below which a command does nothing to a constraint [m/N]."""

REACHED = 1e-6
"""Change of a command that a row may still ask for [N]."""

SAME = 1e-12
"""Part of a unit row that is added to the diagonal, since two rows may be the same."""


@kernel
def nearest_allowed(slopes: Array, lack: Array, at: Array, wanted: Array, low: Array, high: Array) -> Array:
    """Return the command nearest to the wanted one that the constraints allow, linearised at one; shape (m,).

    Args:
        slopes: by the command, of each constraint at each sample, shape (k r, m). lack: at the command `at`, (k, r).
        at, wanted: commands [N], shape (m,). low, high: bounds [N], shape (m,).
    """
    (samples, count), m = lack.shape, len(wanted)
    rows, wants = np.empty_like(slopes), np.full(samples * count, -np.inf)
    for i in range(len(slopes)):
        size = 0.0
        for a in range(m):
            size += slopes[i, a] * slopes[i, a]
        size = np.sqrt(size)
        moving = size > SLOPE_MIN
        size = max(size, SLOPE_MIN)
        if moving:
            wants[i] = lack[i // count, i % count] / size
        for a in range(m):
            rows[i, a] = slopes[i, a] / size
            wants[i] += rows[i, a] * (at[a] - wanted[a])  # needed from the wanted command on
    kept, change = np.zeros(len(slopes), dtype=np.bool_), np.zeros(m)
    worst, missed = np.zeros(count, dtype=np.int64), np.zeros(count)
    for _ in range(ROUNDS):
        missed[:] = -np.inf
        for i in range(len(slopes)):
            left = wants[i]
            for a in range(m):
                left -= rows[i, a] * change[a]
            if left > missed[i % count]:
                missed[i % count], worst[i % count] = left, i
        added = 0
        while added < min(ROWS, count):
            r = int(np.argmax(missed))
            if not missed[r] > REACHED:
                break
            kept[worst[r]], missed[r] = True, -np.inf
            added += 1
        if added == 0:
            break
        change = smallest_change(rows[kept], wants[kept], low - wanted, high - wanted)
    return np.minimum(np.maximum(wanted + change, low), high)


@kernel
def smallest_change(rows: Array, missing: Array, low: Array, high: Array) -> Array:
    """Return the smallest x that adds what is missing, shape (n,); the bounds come first.

    Args:
        rows: G, unit rows, shape (r, n). missing: b, shape (r,).
        low, high: bounds, shape (n,), zero between them.
    """
    count, n = rows.shape
    free = high > low  # those that cannot change leave the program
    inner = 0
    for a in range(n):
        inner += 1 if free[a] else 0
    x, total = low.copy(), count + 2 * inner
    if inner == 0:
        return x
    matrix, wanted = np.zeros((total, inner)), np.zeros(total)
    for i in range(count):
        wanted[i] = missing[i]
    column = 0
    for a in range(n):
        if free[a]:
            for i in range(count):
                matrix[i, column] = rows[i, a]
            matrix[count + column, column], wanted[count + column] = 1.0, low[a]
            matrix[count + inner + column, column], wanted[count + inner + column] = -1.0, -high[a]
            column += 1
        else:
            for i in range(count):
                wanted[i] -= rows[i, a] * low[a]
    gram = np.zeros((total, total))
    for i in range(total):
        for j in range(total):
            for a in range(inner):
                gram[i, j] += matrix[i, a] * matrix[j, a]
        if i < count:
            gram[i, i] += 1.0 / WEIGHT
    y, active = np.zeros(total), np.zeros(total, dtype=np.bool_)
    enough = TOLERANCE * max(np.max(np.abs(wanted)), 1e-30)
    for _ in range(CHANGES):
        worst, most = 0, -np.inf
        for i in range(total):
            left = 0.0 if active[i] else wanted[i]
            if not active[i]:
                for j in range(total):
                    left -= gram[i, j] * y[j]
            if left > most:
                worst, most = i, left
        if most <= enough:
            break
        active[worst] = True
        _with_positive(gram, wanted, y, active)
    column = 0
    for a in range(n):
        if free[a]:
            value = 0.0
            for i in range(total):
                value += matrix[i, column] * y[i]
            x[a] = min(max(value, low[a]), high[a])
            column += 1
    return x


@kernel
def _with_positive(gram: Array, wanted: Array, y: Array, active: Mask) -> None:
    """Write the multipliers for these active rows; those that would be negative leave, and `active` with them."""
    while True:
        at = np.flatnonzero(active)
        size = len(at)
        if size == 0:
            y[:] = 0.0
            return
        new = _solved(gram, wanted, at)
        part, leaving, negative = np.inf, 0, False
        for i in range(size):
            if new[i] <= 0.0:
                ratio = y[at[i]] / max(y[at[i]] - new[i], 1e-300)
                if not negative or ratio < part:
                    part = ratio
                negative = True
        if not negative:
            y[:] = 0.0
            for i in range(size):
                y[at[i]] = new[i]
            return
        lowest = np.inf
        for i in range(size):
            moved = y[at[i]] + min(part, 1.0) * (new[i] - y[at[i]])
            if new[i] <= 0.0 and moved < lowest:
                lowest, leaving = moved, i
            y[at[i]] = max(moved, 0.0)
        for i in range(size):
            if new[i] <= 0.0 and (i == leaving or y[at[i]] <= 1e-14):
                active[at[i]], y[at[i]] = False, 0.0


@lean
def _factor(block: Array) -> None:
    """Factor a symmetric positive definite matrix in place: the lower triangle of Cholesky's."""
    for i in range(len(block)):
        for j in range(i + 1):
            total = block[i, j]
            for k in range(j):
                total -= block[i, k] * block[j, k]
            block[i, j] = np.sqrt(max(total, SAME)) if i == j else total / block[j, j]


@kernel
def _solved(gram: Array, wanted: Array, at: NDArray[np.int64]) -> Array:
    """Return the solution of the rows and columns `at` of a system."""
    size = len(at)
    block, x = np.empty((size, size)), np.empty(size)
    for i in range(size):
        x[i] = wanted[at[i]]
        for j in range(size):
            block[i, j] = gram[at[i], at[j]]
        block[i, i] += SAME
    _factor(block)
    for i in range(size):
        for k in range(i):
            x[i] -= block[i, k] * x[k]
        x[i] /= block[i, i]
    for i in range(size - 1, -1, -1):
        for k in range(i + 1, size):
            x[i] -= block[k, i] * x[k]
        x[i] /= block[i, i]
    return x
