"""Time steps of the strain rod that never fail: Newton's method on the balance, shorter steps, and a minimum last.

A step is solved by a damped Newton method whose factors are kept while they contract; what decides is the correction,
which does not depend on how the equations are scaled (P. Deuflhard, Newton Methods for Nonlinear Problems, 2004,
section 3.3: natural monotonicity test, simplified Newton steps). Where it comes to no end, the step is halved, and
parts that are too violent all the same are taken as implicit Euler steps, which are minima of an energy and always
exist; they take energy away, are first-order in time, and are counted.

The rates after a step are those of the modes nearest to the points' velocities, in the mass metric, which takes energy
away, and gives none.
"""

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.linear import factor_lu, factor_symmetric, solve_lu, solve_symmetric
from tendond.model.strain.equations import (
    Loads,
    Scratch,
    begin_step,
    find_mass,
    find_matrix,
    find_residual,
    mass_matrix,
    scratch_for,
)
from tendond.model.strain.kinematics import find_shape
from tendond.model.strain.layout import Layout
from tendond.model.strain.statics import find_energy, minimise
from tendond.model.strain.tendons import find_paths

Array = NDArray[np.float64]

__all__ = ["Loads", "Scratch", "advance", "mass_matrix", "scratch_for"]

ITERATIONS = 15
"""Of Newton's method; one that needs more is split into shorter steps."""

SPLITS = 3
"""Halvings of a step at most, before implicit Euler steps take over."""

CONTRACTION = 0.2
"""Of the correction in one step, above which a new matrix is worth its price."""

SHORTEST = 1.0 / 64.0
"""Part of Newton's step, below which it leads nowhere."""


@inlined
def _size(work: Scratch, vector: Array) -> float:
    """Rotation or stretch that a change of the modes stands for, squared."""
    total = 0.0
    for a in range(len(vector)):
        total += work.scale[a] * vector[a] * vector[a]
    return total


@inlined
def _energy(layout: Layout, vector: Array) -> float:
    """Twice the elastic energy of a change of the modes [J]."""
    total = 0.0
    for a in range(len(vector)):
        total += layout.stiffness[a, a] * vector[a] * vector[a]
    return total


@lean
def solve_step(layout: Layout, loads: Loads, h: float, tolerance: float, work: Scratch) -> int:
    """Solve one step from `work.q0` to `work.q1`, which holds a first guess, after `begin_step`.

    Returns:
        The residuals it took; -1 if they come to no end.
    """
    n = len(work.q0)
    q1, trial, step, correction = work.q1, work.trial, work.w1, work.correction
    target = tolerance * tolerance * work.unit[0]
    find_residual(layout, loads, work.q0, q1, h, work)
    find_matrix(layout, loads, q1, h, work)
    if not factor_lu(work.matrix, work.rows, n):
        return -1
    for a in range(n):
        step[a] = work.residual[a]
    solve_lu(work.matrix, work.rows, step, n)
    size, energy = _size(work, step), _energy(layout, step)
    part = 1.0
    for count in range(2, ITERATIONS + 2):
        if not size < 1e300:
            return -1
        if energy <= target:
            for a in range(n):
                q1[a] -= step[a]
            find_shape(layout, q1, work.after)
            return count
        for a in range(n):
            trial[a] = q1[a] - part * step[a]
        find_residual(layout, loads, work.q0, trial, h, work)
        for a in range(n):
            correction[a] = work.residual[a]
        solve_lu(work.matrix, work.rows, correction, n)
        left = _size(work, correction)
        if not left <= (1.0 - 0.25 * part) ** 2 * size:
            left_energy = _energy(layout, correction)
            if not (part == 1.0 and left_energy <= target):
                part *= 0.5
                if part < SHORTEST:
                    return -1
                continue
        for a in range(n):
            q1[a] = trial[a]
        if part == 1.0:
            reached = _energy(layout, correction)
            if reached <= target:
                return count
            ratio = left / size
            if ratio < CONTRACTION * CONTRACTION:
                for a in range(n):
                    step[a] = correction[a]
                size = left
                energy = ratio * reached  # what is left after it
                continue
        find_matrix(layout, loads, q1, h, work)
        if not factor_lu(work.matrix, work.rows, n):
            return -1
        for a in range(n):
            step[a] = work.residual[a]
        solve_lu(work.matrix, work.rows, step, n)
        size, energy = _size(work, step), np.inf
        part = min(1.0, 2.0 * part)
    return -1


@lean
def project_rates(layout: Layout, old: float, new: float, work: Scratch) -> float:
    """Write to `work.w1` the rates nearest to the points' velocities; return twice their kinetic energy [J].

    The velocities are `new` (x1 - x0) - `old` v0: 2 / h and 1 for the balanced step, 1 / h and 0 for implicit Euler's.
    """
    n = len(work.q1)
    w1, one, two = work.w1, work.before, work.after
    find_mass(layout, two, work, work.matrix)
    for a in range(n):
        w1[a] = 0.0
    for j in range(len(layout.mass)):
        m, k = layout.mass[j], layout.place[j]
        x = m * (new * (two.point[j, 0] - one.point[j, 0]) - old * work.velocity[j, 0])
        y = m * (new * (two.point[j, 1] - one.point[j, 1]) - old * work.velocity[j, 1])
        z = m * (new * (two.point[j, 2] - one.point[j, 2]) - old * work.velocity[j, 2])
        for a in range(layout.last[k - 1]):
            w1[a] += x * two.jacobian[j, 0, a] + y * two.jacobian[j, 1, a] + z * two.jacobian[j, 2, a]
    for k in range(1, len(layout.polar)):
        if layout.polar[k] != 0.0:
            last = layout.last[k - 1]
            rate = 0.0
            for a in range(last):
                rate += 0.5 * (one.spin[k, a] + two.spin[k, a]) * (work.q1[a] - work.q0[a])
            turned = layout.polar[k] * (new * rate - old * work.spin[k])
            for a in range(last):
                w1[a] += turned * two.spin[k, a]
    for a in range(n):
        work.row[a] = w1[a]
    if not factor_symmetric(work.matrix, n):
        return -1.0
    solve_symmetric(work.matrix, w1, n)
    twice = 0.0
    for a in range(n):
        twice += work.row[a] * w1[a]
    return twice


@lean
def damped_step(layout: Layout, loads: Loads, h: float, tolerance: float, work: Scratch) -> int:
    """Take an implicit Euler step from `work.q0` to `work.q1`, after `begin_step`; return Newton's iterations.

    It is the minimum of an energy, the least that was found if Newton's method ends early: whatever comes out, the
    potential energy after it is not above all energy before it, and the rates are scaled so that the sum is not either.
    """
    n = len(work.q0)
    for a in range(n):
        work.q1[a] = work.q0[a]
    before, _ = find_energy(layout, loads, work.q1, 1.0 / h, work)  # at q0: potential and kinetic energy
    count = minimise(layout, loads, work.q1, 1.0 / h, tolerance, work)
    after, _ = find_energy(layout, loads, work.q1, 1.0 / h, work)
    inertia = 0.0  # what the minimum has above the potential energy, and lets go
    one, two = work.before, work.after
    for j in range(len(layout.mass)):
        for c in range(3):
            v = (two.point[j, c] - one.point[j, c]) / h - work.velocity[j, c]
            inertia += 0.5 * layout.mass[j] * v * v
    for k in range(1, len(layout.polar)):
        turned = 0.0
        for a in range(layout.last[k - 1]):
            turned += one.spin[k, a] * (work.q1[a] - work.q0[a])
        turned = turned / h - work.spin[k]
        inertia += 0.5 * layout.polar[k] * turned * turned
    twice = project_rates(layout, 0.0, 1.0 / h, work)
    allowed = max(0.0, 2.0 * (before - after + inertia))
    if not twice <= allowed:
        factor = np.sqrt(allowed / twice) if twice > 0.0 else 0.0
        for a in range(n):
            work.w1[a] *= factor
    return int(abs(count))


@lean
def advance(
    layout: Layout, loads: Loads, q: Array, w: Array, h: float, tolerance: float, work: Scratch
) -> tuple[int, int, int]:
    """Advance q and w by the time h, in place: one step, or, where that does not converge, as many shorter ones.

    Args:
        layout: of the robot.
        loads: on it, held over the step.
        q: strains, shape (n,).
        w: their rates [1/s], shape (n,).
        h: [s].
        tolerance: of the strains [rad], in the measure of energy.
        work: scratch arrays.

    Returns:
        Residuals and iterations of all steps; the number of steps; how many of these were implicit Euler's.
    """
    n = len(q)
    q0, w0, q1 = work.q0, work.w0, work.q1
    total = steps = damped = done = 0
    whole = 1 << SPLITS
    part = whole
    for a in range(n):
        q0[a], w0[a] = q[a], w[a]
    while done < whole:
        find_shape(layout, q0, work.before)
        if len(work.taut) > 0:
            find_paths(layout, q0, work.paths_before)
        while True:
            length = h * part / whole
            begin_step(layout, q0, w0, length, work)
            for a in range(n):
                q1[a] = q0[a] + length * w0[a]
            count = solve_step(layout, loads, length, tolerance, work)
            if count > 0:
                twice = project_rates(layout, 1.0, 2.0 / length, work)
                if twice >= 0.0:
                    break
            if part > 1:
                part //= 2
                continue
            count = damped_step(layout, loads, length, tolerance, work)
            damped += 1
            break
        total += count
        steps += 1
        done += part
        for a in range(n):
            q0[a], w0[a] = q1[a], work.w1[a]
        while 2 * part <= whole - done and done % (2 * part) == 0:
            part *= 2
    for a in range(n):
        q[a], w[a] = q0[a], w0[a]
    return total, steps, damped
