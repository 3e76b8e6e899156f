"""Allocate a change of the tip's pose to the tensions of all tendons: the pose first, then as little tension as can be.

Sections are coupled: a tendon that ends at the tip bends every section that it passes. So the pose's derivative E by
all tensions T is inverted as a whole. In each step two least-squares problems with bounds are solved, one after the
other (Siciliano & Slotine, ICAR 1991, priority of tasks; De Luca & Ferrajoli, IROS 2008):

    1. minimise |E dT - e|^2 + rho |dT|^2                     low <= dT <= high
    2. minimise |T + dT + N a - T_0|^2 by a                   low <= dT + N a <= high,    E N = 0

e is the change wanted and N spans the changes of tension that leave the pose. T_0 is the pretension, or the middle of
the tensions' range. Both are least distance problems (Lawson & Hanson, Solving Least Squares Problems, 1974, chapter
23) and end after a number of pivots by non-negative least squares.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

Array = NDArray[np.float64]

RIDGE = 1e-3
"""sqrt(rho), of E's norm: bounds a step in directions that hardly move the tip. It delays them, and moves no rest."""

FREE = 1e-4
"""Singular values of E below this part of the largest one count as zero: those changes leave the pose."""


def allocate(jacobian: Array, wanted: Array, tension: Array, preferred: Array, low: Array, high: Array) -> Array:
    """Return the change of the tensions [N], shape (n,).

    Args:
        jacobian: E, shape (m, n). wanted: e, shape (m,).
        tension: T [N], shape (n,). preferred: T_0 [N], shape (n,).
        low, high: bounds of the change [N], shape (n,); low <= high.
    """
    n = len(tension)
    _, sizes, rows = np.linalg.svd(jacobian, full_matrices=True)
    size = float(sizes[0]) if len(sizes) else 0.0
    if size == 0.0:
        return np.clip(preferred - tension, low, high)
    tall = np.vstack((jacobian / size, RIDGE * np.eye(n)))
    change = np.clip(bounded(tall, np.concatenate((wanted / size, np.zeros(n))), np.eye(n), low, high), low, high)
    moved = sizes > FREE * size
    free = np.vstack((rows[: len(sizes)][~moved], rows[len(sizes) :])).T
    if free.shape[1] == 0:
        return change
    along = bounded(np.eye(free.shape[1]), free.T @ (preferred - tension - change), free, low - change, high - change)
    return np.clip(change + free @ along, low, high)


def bounded(a: Array, b: Array, through: Array, low: Array, high: Array) -> Array:
    """Return x that minimises |a x - b|^2 with low <= through x <= high, shape (k,).

    Args:
        a: of full column rank, shape (m, k). b: shape (m,).
        through: shape (n, k). low, high: shape (n,); bounds that can be met.
    """
    q, r = np.linalg.qr(a)
    free = np.linalg.solve(r, q.T @ b)
    reached = through @ free
    scale = max(float(np.max(high - low)), 1e-9)
    if np.all(reached >= low - 1e-12 * scale) and np.all(reached <= high + 1e-12 * scale):
        return free
    # With y = r (x - free): minimise |y| where g y >= h.
    slopes = np.linalg.solve(r.T, through.T).T
    g, h = np.vstack((slopes, -slopes)), np.concatenate((low - reached, reached - high))
    size = max(float(np.max(np.abs(h))), 1e-12)
    try:
        pivots, _ = nnls(np.vstack((g.T, h / size)), np.append(np.zeros(len(free)), 1.0))
    except RuntimeError:  # too many pivots: nothing is changed in this cycle
        return np.zeros(len(free))
    left = np.append(g.T @ pivots, h @ pivots / size - 1.0)
    if not abs(left[-1]) > 1e-12:  # bounds that only rounding meets
        return np.zeros(len(free))
    return np.asarray(free + np.linalg.solve(r, -left[:-1] / left[-1] * size))
