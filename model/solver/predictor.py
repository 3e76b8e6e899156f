"""Predict a step's solution: extrapolation of past solutions, of the order that would have predicted the last one best.

With backward differences, extrapolation of order p is the sum of the first p + 1 of them, and its error at the last
step is the next one. A smooth motion is then followed so closely that a step often needs a single march; after a
jump, or in noise, the guess falls back to the last solution.
"""

from typing import Any

from tendond.model.numerics.compile import inlined

PAST = 7
"""Solutions that an extrapolation may use."""

RING = PAST + 1
"""Solutions that are kept: one more, so that a step that fails has overwritten none of them."""


@inlined
def predict(unknowns: Any, count: int, scale: Any, differences: Any, size: int, guess: Any) -> None:
    """Write the guess for step `count` + 1.

    Args:
        unknowns: past solutions, a ring with step k at k modulo `RING`, shape (RING, m).
        count: steps taken.
        scale: scale of each unknown, to compare them, shape (m,).
        differences: scratch, shape (PAST, m).
        size: unknowns to compare; all are predicted.
        guess: written, shape (m,).
    """
    m = guess.shape[0]
    for k in range(PAST):
        for j in range(m):
            differences[k, j] = unknowns[(count - k) % RING, j]
    for order in range(1, PAST):
        for k in range(PAST - 1, order - 1, -1):
            for j in range(m):
                differences[k, j] = differences[k - 1, j] - differences[k, j]
    best, missed_min = 0, -1.0
    for order in range(PAST - 1):
        missed = 0.0
        for j in range(size):
            missed += (differences[order + 1, j] / scale[j]) ** 2
        if missed_min < 0.0 or missed < missed_min:
            best, missed_min = order, missed
    for j in range(m):
        guess[j] = differences[0, j]
    for order in range(1, best + 1):
        for j in range(m):
            guess[j] += differences[order, j]
