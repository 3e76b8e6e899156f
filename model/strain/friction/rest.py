"""Equilibria of rods whose tendons rub, from a state before: Newton's method with a search along its steps.

Friction keeps the path by which a shape was reached; these equilibria are steps of a slow motion, by implicit Euler.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import lean
from tendond.model.numerics.elimination import factor_lu, solve_lu
from tendond.model.numerics.products import padded
from tendond.model.strain.friction.pulls import add_friction_curvature, begin_friction, find_friction
from tendond.model.strain.friction.sliding import find_slopes
from tendond.model.strain.friction.solve import LEFT, TRIALS, along, next_part
from tendond.model.strain.layout import Layout
from tendond.model.strain.minima.energy import find_energy
from tendond.model.strain.minima.hessian import find_hessian
from tendond.model.strain.stepping.newton import energy_of
from tendond.model.strain.stepping.scratch import Loads, Scratch
from tendond.model.strain.tendons import find_paths

Array = NDArray[np.float64]

ITERATIONS = 60
"""Newton's iterations; where more are needed, the loads come in parts."""


@lean
def _find_lack(layout: Layout, loads: Loads, other: Loads, q: Array, work: Scratch) -> None:
    """Write what is missing to balance at q, shape (n,), to `work.residual`; `other`: without tendons that rub."""
    grip = work.grip
    find_energy(layout, other, q, 0.0, work)
    find_friction(layout, loads, q, work)
    for f in range(len(grip.tendon)):
        for j in range(grip.number[f]):
            for a in range(len(q)):
                work.residual[a] -= grip.tension[f, 1 + j] * grip.after.gradient[f, j, a]


@lean
def _find_correction(layout: Layout, other: Loads, q: Array, work: Scratch) -> bool:
    """Write Newton's correction at q to `work.w1`, with a new matrix; return false where that is singular."""
    grip, n, width = work.grip, len(q), padded(len(q))
    find_hessian(layout, other, q, 0.0, True, work)
    add_friction_curvature(work, work.hessian)
    for f in range(len(grip.tendon)):
        find_slopes(layout, grip, f, n)
        for j in range(grip.number[f]):
            for a in range(n):
                for b in range(n):
                    work.hessian[a, b] -= grip.after.gradient[f, j, a] * grip.slope[f, j, b]
    for a in range(n):
        for b in range(n):
            work.matrix[a * width + b] = work.hessian[a, b]
        work.w1[a] = work.residual[a]
    if not factor_lu(work.matrix, work.rows, n, width, work.solving):
        return False
    solve_lu(work.matrix, work.rows, work.w1, n, width, work.solving)
    return True


@lean
def settle(layout: Layout, loads: Loads, other: Loads, q: Array, tolerance: float, work: Scratch) -> int:
    """Move q to an equilibrium, in place.

    Args:
        layout: of the robot.
        loads: on it.
        other: the same, where tendons that rub are slack.
        q: strains, shape (n,): a guess.
        tolerance: of q [rad], in the measure of energy.
        work: scratch arrays; `q0` and `grip.start` are the strains and tensions before.

    Returns:
        Newton's iterations; -1 where they came to no end.
    """
    n, width = len(q), padded(len(q))
    trial, step = work.trial, work.w1
    target = tolerance * tolerance * work.unit[0]
    find_paths(layout, work.q0, work.paths_before)
    begin_friction(layout, work)
    _find_lack(layout, loads, other, q, work)
    for count in range(1, ITERATIONS + 1):
        if not _find_correction(layout, other, q, work):
            return -1
        size = energy_of(layout, step)
        if not math.isfinite(size):
            return -1
        if size <= target:  # at an equilibrium the search would follow the signs of rounding
            for a in range(n):
                trial[a] = q[a] - step[a]
            _find_lack(layout, loads, other, trial, work)
            for a in range(n):
                q[a] = trial[a]
            return count
        start = along(step, work.residual)
        part, low, left, high, beyond = 1.0, 0.0, start, -1.0, 0.0
        for _ in range(TRIALS):
            for a in range(n):
                trial[a] = q[a] - part * step[a]
            _find_lack(layout, loads, other, trial, work)
            work_left = along(step, work.residual)
            if abs(work_left) <= LEFT * abs(start) or not start > 0.0 or (work_left > 0.0 and high < 0.0):
                break
            if work_left > 0.0:
                low, left = part, work_left
            else:
                high, beyond = part, work_left
            part = next_part(low, left, high, beyond)
        for a in range(n):
            q[a] = trial[a]
        if part == 1.0:
            for a in range(n):
                work.correction[a] = work.residual[a]
            solve_lu(work.matrix, work.rows, work.correction, n, width, work.solving)
            if energy_of(layout, work.correction) <= target:
                return count
    return -1
