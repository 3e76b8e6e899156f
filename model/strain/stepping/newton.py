"""Newton's method for the balance of a step, whose factors are kept while they contract.

What decides is the correction, which does not depend on how the equations are scaled (P. Deuflhard, Newton Methods for
Nonlinear Problems, 2004, section 3.3: natural monotonicity test, simplified Newton steps).
"""

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.elimination import factor_lu, solve_lu
from tendond.model.numerics.products import padded
from tendond.model.strain.layout import Layout
from tendond.model.strain.stepping.balance import find_residual
from tendond.model.strain.stepping.scratch import Loads, Scratch
from tendond.model.strain.stepping.tangent import find_matrix

Array = NDArray[np.float64]

ITERATIONS = 15
"""Iterations of Newton's method; one that needs more is split into shorter steps. Chosen; `tendond bench rod
--survey 1000` counts the steps that are split."""

CONTRACTION = 0.2
"""Ratio of the correction in one step, above which a new matrix is worth its price. Chosen: it moves time, not results,
beyond the tolerance."""

BALANCE = 2e-8
"""Work of the residual over a step, as a part of the shape's elastic energy twice over, above which the last correction
is made as well: a step much shorter than the robot's periods has large forces on small moves, and would gain or lose
that work as energy. Chosen below `offline.bench.general_rod.survey.GROWTH`."""

SHORTEST = 1.0 / 64.0
"""Part of Newton's step, below which it leads nowhere: six halvings. Chosen; the step is split then."""


@inlined
def _size(work: Scratch, vector: Array) -> float:
    """Rotation or stretch that a change of the modes stands for, squared."""
    total = 0.0
    for a in range(len(vector)):
        total += work.scale[a] * vector[a] * vector[a]
    return total


@inlined
def energy_of(layout: Layout, vector: Array) -> float:
    """Twice the elastic energy of a change of the modes [J]."""
    total = 0.0
    for a in range(len(vector)):
        total += layout.stiffness[a, a] * vector[a] * vector[a]
    return total


@lean
def find_correction(layout: Layout, h: float, work: Scratch) -> bool:
    """Write Newton's correction at `work.q1` to `work.w1`, with a new matrix; return false where that is singular."""
    n, width = len(work.q1), padded(len(work.q1))
    find_matrix(layout, h, work)
    if not factor_lu(work.matrix, work.rows, n, width, work.solving):
        return False
    for a in range(n):
        work.w1[a] = work.residual[a]
    solve_lu(work.matrix, work.rows, work.w1, n, width, work.solving)
    return True


@lean
def solve_step(layout: Layout, loads: Loads, h: float, tolerance: float, work: Scratch) -> int:
    """Solve one step from `work.q0` to `work.q1`, which holds a first guess, after `begin_step`.

    Returns:
        The residuals it took; -1 if they come to no end. What `find_residual` writes is at `work.q1`.
    """
    n, width = len(work.q0), padded(len(work.q0))
    q1, trial, step, correction = work.q1, work.trial, work.w1, work.correction
    target = tolerance * tolerance * work.unit[0]
    find_residual(layout, loads, work.q0, q1, h, work)
    if not find_correction(layout, h, work):
        return -1
    size, energy = _size(work, step), energy_of(layout, step)
    part = 1.0
    for count in range(2, ITERATIONS + 2):
        if not size < 1e300:
            return -1
        if energy <= target:
            for a in range(n):
                q1[a] -= step[a]
            find_residual(layout, loads, work.q0, q1, h, work)  # the derivatives of the step need all of it at q1
            return count
        for a in range(n):
            trial[a] = q1[a] - part * step[a]
        find_residual(layout, loads, work.q0, trial, h, work)
        for a in range(n):
            correction[a] = work.residual[a]
        solve_lu(work.matrix, work.rows, correction, n, width, work.solving)
        left = _size(work, correction)
        if not left <= (1.0 - 0.25 * part) ** 2 * size:
            left_energy = energy_of(layout, correction)
            if not (part == 1.0 and left_energy <= target):
                part *= 0.5
                if part < SHORTEST:
                    return -1
                continue
        for a in range(n):
            q1[a] = trial[a]
        if part == 1.0:
            reached = energy_of(layout, correction)
            if reached <= target:
                work_left = 0.0
                for a in range(n):
                    work_left += work.residual[a] * work.change[a]
                if abs(work_left) <= BALANCE * energy_of(layout, q1):
                    return count
                for a in range(n):
                    q1[a] -= correction[a]
                find_residual(layout, loads, work.q0, q1, h, work)
                return count + 1
            ratio = left / size
            if ratio < CONTRACTION * CONTRACTION:
                for a in range(n):
                    step[a] = correction[a]
                size = left
                energy = ratio * reached  # what is left after it
                continue
        if not find_correction(layout, h, work):
            return -1
        size, energy = _size(work, step), np.inf
        part = min(1.0, 2.0 * part)
    return -1
