"""The smallest change of a command that meets a few linear constraints: a strictly convex quadratic program.

    minimise 1/2 |x|^2 + W/2 |s|^2    subject to    G x + s >= b,  low <= x <= high

with unit rows of G, so that s is in the unit of x. The shortfall s keeps it feasible; its weight W makes it negligible
where there is another solution. The dual has bounds only, y >= 0, and is solved by an active set as in Lawson & Hanson,
Solving Least Squares Problems, 1974, chapter 23: rows join where they are violated most, and leave where their
multiplier would become negative.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

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


def nearest_allowed(slopes: Array, lack: Array, at: Array, wanted: Array, bounds: tuple[Array, Array]) -> Array:
    """Return the command nearest to the wanted one that the constraints allow, linearised at one.

    Args:
        slopes: by the command, shape (k r, m). lack: at the command `at`, shape (k, r).
    """
    sizes = np.sqrt(np.einsum("qm,qm->q", slopes, slopes))
    moving, sizes = sizes > SLOPE_MIN, np.maximum(sizes, SLOPE_MIN)
    rows, wants = slopes / sizes[:, None], np.where(moving, lack.ravel() / sizes, -np.inf)
    wants += rows @ (at - wanted)  # needed from the wanted command on
    kept, change = np.zeros(0, dtype=np.intp), np.zeros_like(wanted)
    for _ in range(ROUNDS):
        missed = (wants - rows @ change).reshape(lack.shape)
        samples, places = missed.argmax(axis=0), np.arange(lack.shape[1])
        missed, worst = missed[samples, places], samples * lack.shape[1] + places
        order = np.argsort(missed)[: -ROWS - 1 : -1]
        worst = worst[order[missed[order] > REACHED]]
        if len(worst) == 0:
            break
        kept = np.union1d(kept, worst)
        change = smallest_change(rows[kept], wants[kept], bounds[0] - wanted, bounds[1] - wanted)
    return np.clip(wanted + change, *bounds)


def smallest_change(rows: Array, missing: Array, low: Array, high: Array) -> Array:
    """Return the smallest x that adds what is missing, shape (n,); the bounds come first.

    Args:
        rows: G, unit rows, shape (r, n). missing: b, shape (r,).
        low, high: bounds, shape (n,), zero between them.
    """
    free = high > low
    if not free.all():  # those that cannot change leave the program
        x = np.where(free, 0.0, low)
        if free.any():
            x[free] = smallest_change(rows[:, free], missing - rows @ x, low[free], high[free])
        return x
    count, n = rows.shape
    matrix = np.concatenate((rows, np.eye(n), -np.eye(n)))
    wanted = np.concatenate((missing, low, -high))
    gram = matrix @ matrix.T
    gram[np.arange(count), np.arange(count)] += 1.0 / WEIGHT
    y = np.zeros(len(wanted))
    active = np.zeros(len(wanted), dtype=bool)
    enough = TOLERANCE * max(float(np.max(np.abs(wanted))), 1e-30)
    for _ in range(CHANGES):
        lack = wanted - gram @ y
        lack[active] = 0.0
        worst = int(np.argmax(lack))
        if lack[worst] <= enough:
            break
        active[worst] = True
        y = _with_positive(gram, wanted, y, active)
    return np.clip(matrix.T @ y, low, high)


def _with_positive(gram: Array, wanted: Array, y: Array, active: NDArray[np.bool_]) -> Array:
    """Return the multipliers for these active rows; those that would be negative leave, and `active` with them."""
    while True:
        at = np.flatnonzero(active)
        block = gram[np.ix_(at, at)]
        block[np.arange(len(at)), np.arange(len(at))] += 1e-12  # two rows may be the same
        new = np.linalg.solve(block, wanted[at])
        if (new > 0.0).all():
            y = np.zeros_like(y)
            y[at] = new
            return y
        old = y[at]
        falling = new <= 0.0
        part = float(np.min(old[falling] / np.maximum(old[falling] - new[falling], 1e-300)))
        moved = old + min(part, 1.0) * (new - old)
        y = np.zeros_like(y)
        y[at] = np.maximum(moved, 0.0)
        leave = falling & (moved <= 1e-14)
        leave[np.argmin(np.where(falling, moved, np.inf))] = True
        active[at[leave]] = False
        y[at[leave]] = 0.0
        if not active.any():
            return y
