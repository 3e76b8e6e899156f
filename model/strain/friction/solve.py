"""Newton's method for the balance of a step with tendons that rub: a piecewise smooth one, with a search along steps.

A tendon that sticks is some thirty times as stiff as the rod that it bends, and Newton's step from where it slides
overshoots as much. Along a step the balance is nearly the slope of an energy: what is left of its work on the step is
brought down to half, by secants (Wolfe's second condition), and a new derivative is taken there.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.elimination import solve_lu
from tendond.model.numerics.products import padded
from tendond.model.strain.layout import Layout
from tendond.model.strain.stepping.balance import find_residual
from tendond.model.strain.stepping.newton import energy_of, find_correction
from tendond.model.strain.stepping.scratch import Loads, Scratch

Array = NDArray[np.float64]

ITERATIONS = 40
"""Derivatives that are taken; a step that needs more is split into shorter ones."""

TRIALS = 10
"""Places that are tried along a step."""

LEFT = 0.5
"""Part of the work along a step that may be left at its end."""


@inlined
def along(step: Array, residual: Array) -> float:
    """Return the work of a residual along a step."""
    total = 0.0
    for a in range(len(step)):
        total += step[a] * residual[a]
    return total


@inlined
def next_part(low: float, left: float, high: float, beyond: float) -> float:
    """Return the place between two parts of a step where a secant of the works there, of either sign, is 0."""
    part = low + (high - low) * left / (left - beyond)
    return min(max(part, low + 0.1 * (high - low)), high - 0.1 * (high - low))


@lean
def solve_rubbing(layout: Layout, loads: Loads, h: float, tolerance: float, work: Scratch) -> int:
    """Solve one step from `work.q0` to `work.q1`, which holds a first guess, after `begin_step`.

    Returns:
        The residuals it took; -1 if they come to no end. What `find_residual` writes is at `work.q1`.
    """
    n, width = len(work.q0), padded(len(work.q0))
    q1, trial, step = work.q1, work.trial, work.w1
    target = tolerance * tolerance * work.unit[0]
    find_residual(layout, loads, work.q0, q1, h, work)
    count = 1
    for _ in range(ITERATIONS):
        if not find_correction(layout, h, work):
            return -1
        size = energy_of(layout, step)
        if not math.isfinite(size):
            return -1
        start = along(step, work.residual)
        part, low, left, high, beyond = 1.0, 0.0, start, -1.0, 0.0
        for _ in range(TRIALS):
            for a in range(n):
                trial[a] = q1[a] - part * step[a]
            find_residual(layout, loads, work.q0, trial, h, work)
            count += 1
            work_left = along(step, work.residual)
            if abs(work_left) <= LEFT * abs(start) or not start > 0.0 or (work_left > 0.0 and high < 0.0):
                break
            if work_left > 0.0:
                low, left = part, work_left
            else:
                high, beyond = part, work_left
            part = next_part(low, left, high, beyond)
        for a in range(n):
            q1[a] = trial[a]
        if part == 1.0:
            if size <= target:
                return count
            for a in range(n):
                work.correction[a] = work.residual[a]
            solve_lu(work.matrix, work.rows, work.correction, n, width, work.solving)
            if energy_of(layout, work.correction) <= target:
                return count
    return -1
