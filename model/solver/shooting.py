"""The boundary value problem of one step: shooting by a quasi-Newton method, in one compiled call.

Unknowns are the base load n(0), m(0), and in a displacement-driven rod the n tensions beside them. The raw map takes
all 6 + n of them to the residual at the tip (6) and the tendons' path lengths (n); its Jacobian, a difference Jacobian
of eight-lane marches, is carried from step to step, kept up to date by Broyden's update and made anew when an iteration
contracts poorly. The same Jacobian gives the sensitivities.
"""

import math
from typing import Any

from tendond.model.numerics.compile import inlined, kernel
from tendond.model.numerics.linear import solve_in_place
from tendond.model.solver.lanes import STATE
from tendond.model.solver.march import Shots, march
from tendond.model.solver.problem import Problem, Profile, RodData
from tendond.model.solver.work import LANES, Work

SOLVED, DIVERGED = 0, 1

CONTRACTION_MAX = 0.5
"""Residual after an iteration, of that before, above which the Jacobian is made anew."""

ARM = 2.0
"""Arm at which a missing moment counts as a missing force, of the rod's length: 1 m on the paper's robot."""

DIFFERENCE_STEP = 1e-7
"""Difference step of the Jacobian, of an unknown: some ten times the square root of the rounding."""


@inlined
def evaluate(rod: RodData, work: Work, problem: Problem, unknown: Any, profile: Profile, raw: Any) -> None:
    """One shot: raw(unknown) = (residual of force and moment at the tip, tendon lengths)."""
    many = work.shots
    for i in range(rod.tendons):
        work.pull[i] = unknown[6 + i]
    one = Shots(unknown[:6], work.pull, many.node, many.length, many.residual, many.stages)
    march(rod.one, rod, problem, one, profile)
    for j in range(6):
        raw[j] = one.residual[j]
    for i in range(rod.tendons):
        raw[6 + i] = one.length[i]


@inlined
def spread(rod: RodData, work: Work, unknown: Any) -> None:
    """Give every lane the base loads and tensions of `unknown`."""
    shots = work.shots
    for lane in range(LANES):
        for j in range(6):
            shots.base[j * LANES + lane] = unknown[j]
        for i in range(rod.tendons):
            shots.tension[i * LANES + lane] = unknown[6 + i]


@inlined
def perturb(work: Work, column: int, lane: int, step: float) -> None:
    """Change one unknown of one lane."""
    if column < 6:
        work.shots.base[column * LANES + lane] += step
    else:
        work.shots.tension[(column - 6) * LANES + lane] += step


@inlined
def perturbation(work: Work, unknown: Any, column: int) -> float:
    """Difference step of an unknown: `DIFFERENCE_STEP` of it, and of its scale where it vanishes."""
    return float(DIFFERENCE_STEP * (work.scale[column] + abs(unknown[column])))


@inlined
def change(values: Any, row: int, lane: int, unperturbed: float) -> float:
    """Change of a row in a perturbed lane."""
    return float(values[row * LANES + lane] - unperturbed)


@inlined
def differentiate(
    rod: RodData, work: Work, problem: Problem, unknown: Any, columns: int, profile: Profile, jacobian: Any
) -> int:
    """First `columns` columns of the raw map's Jacobian at `unknown`, by differences, and the tip's; returns marches.

    `work.raw` and the node of `work.shots` must hold the shot at `unknown`.
    """
    shots = work.shots
    for j in range(STATE):
        for column in range(columns):
            work.tip[j, column] = shots.node[j]
    marches = 0
    for start in range(0, columns, LANES):
        count = min(LANES, columns - start)
        spread(rod, work, unknown)
        for lane in range(count):
            perturb(work, start + lane, lane, perturbation(work, unknown, start + lane))
        march(rod.many, rod, problem, shots, profile)
        for lane in range(count):
            column = start + lane
            inverse = 1.0 / perturbation(work, unknown, column)
            for j in range(6):
                jacobian[j, column] = change(shots.residual, j, lane, work.raw[j]) * inverse
            for i in range(rod.tendons):
                jacobian[6 + i, column] = change(shots.length, i, lane, work.raw[6 + i]) * inverse
            for j in range(STATE):
                work.tip[j, column] = change(shots.node, j, lane, work.tip[j, column]) * inverse
        marches += 1
    return marches


@inlined
def _error(rod: RodData, problem: Problem, unknown: Any, raw: Any) -> float:
    """Norm of the residual [N]: force and moment at the tip, and the tendons' law T = max(0, k (d_commanded - d))."""
    total, arm = 0.0, ARM * rod.length
    for j in range(3):
        total += raw[j] * raw[j]
    for j in range(3, 6):
        total += (raw[j] / arm) * (raw[j] / arm)
    if problem.displacement_driven:
        for i in range(rod.tendons):
            missing = unknown[6 + i] - max(0.0, string_tension(rod, problem, raw, i))
            total += missing * missing
    return float(math.sqrt(total))


@inlined
def string_tension(rod: RodData, problem: Problem, raw: Any, i: int) -> float:
    """k (d_commanded - d): tension of tendon i where it is positive [N]."""
    return float(rod.stiffness * (problem.loads[i] - rod.length + raw[6 + i]))


@inlined
def newton_matrix(rod: RodData, work: Work, problem: Problem, jacobian: Any) -> int:
    """Fill `work.matrix` with the equations' Jacobian and return their number; a slack tendon's equation is T = 0."""
    n = rod.tendons
    m = 6 + n if problem.displacement_driven else 6
    for j in range(6):
        for column in range(m):
            work.matrix[j, column] = jacobian[j, column]
    for row in range(6, m):
        stiffness = rod.stiffness if string_tension(rod, problem, work.raw, row - 6) > 0.0 else 0.0
        for column in range(m):
            work.matrix[row, column] = -stiffness * jacobian[row, column]
        work.matrix[row, row] += 1.0
    return m


@inlined
def _newton_step(rod: RodData, work: Work, problem: Problem, unknown: Any, jacobian: Any) -> bool:
    """Solve for the (semismooth) Newton step into `work.step`; False where the equations are singular."""
    m = newton_matrix(rod, work, problem, jacobian)
    for j in range(6):
        work.step[j] = -work.raw[j]
    for row in range(6, m):
        work.step[row] = max(0.0, string_tension(rod, problem, work.raw, row - 6)) - unknown[row]
    return bool(solve_in_place(work.matrix, work.step, m))


@inlined
def _broyden(work: Work, m: int, jacobian: Any) -> None:
    """Update the raw Jacobian by Broyden's rank-one formula, from the step taken and the change of the raw map."""
    square = 0.0
    for column in range(m):
        square += (work.step[column] / work.scale[column]) ** 2
    if square == 0.0:
        return
    for j in range(m):
        defect = work.raw_trial[j] - work.raw[j]
        for column in range(m):
            defect -= jacobian[j, column] * work.step[column]
        defect /= square
        for column in range(m):
            jacobian[j, column] += defect * work.step[column] / work.scale[column] ** 2


@kernel
def solve(
    rod: RodData, work: Work, problem: Problem, unknown: Any, profile: Profile, jacobian: Any
) -> tuple[int, float, int]:
    """Solve for `unknown`, from the guess that it holds.

    Args:
        rod: the rod.
        work: its scratch memory.
        problem: problem of the step.
        unknown: guess in, solution out: n(0), m(0), T; shape (6 + n,).
        profile: the solution along the rod, written.
        jacobian: guess in (all zero: none), last one out, shape (6 + n, 6 + n).

    Returns:
        SOLVED or DIVERGED, the residual's norm, marches spent (one for each call of `march`).
    """
    n = rod.tendons
    m = 6 + n if problem.displacement_driven else 6
    if not problem.displacement_driven:
        for i in range(n):
            unknown[6 + i] = problem.loads[i]
    evaluate(rod, work, problem, unknown, profile, work.raw)
    marches = 1
    error = _error(rod, problem, unknown, work.raw)
    fresh = False  # the Jacobian was made at `unknown`
    poor = jacobian[0, 0] == 0.0  # the Jacobian has to be made anew
    moved = False  # the last march was not the one at `unknown`
    factor = 1.0  # of the Newton step
    while error > rod.tolerance:
        if marches >= rod.budget or factor < 1e-3:
            return DIVERGED, error, marches
        if poor and not fresh:
            if moved:
                evaluate(rod, work, problem, unknown, profile, work.raw)
                marches += 1
            marches += differentiate(rod, work, problem, unknown, m, profile, jacobian)
            fresh, poor = True, False
        solvable = _newton_step(rod, work, problem, unknown, jacobian)
        if not solvable and fresh:
            return DIVERGED, error, marches
        for column in range(m):
            work.step[column] *= factor
            work.trial[column] = unknown[column] + work.step[column]
        for column in range(m, 6 + n):
            work.trial[column] = unknown[column]
        evaluate(rod, work, problem, work.trial, profile, work.raw_trial)
        marches += 1
        trial_error = _error(rod, problem, work.trial, work.raw_trial)
        if solvable and (trial_error <= rod.tolerance or trial_error < (1.0 - 0.1 * factor) * error):
            _broyden(work, m, jacobian)
            for column in range(6 + n):
                unknown[column] = work.trial[column]
                work.raw[column] = work.raw_trial[column]
            poor = trial_error > CONTRACTION_MAX * error
            fresh = moved = False
            factor = 1.0
            error = trial_error
        else:
            moved = poor = True
            if fresh:
                factor *= 0.3
    if not error <= rod.tolerance:  # NaN
        return DIVERGED, error, marches
    if jacobian[0, 0] != 0.0 and _newton_step(rod, work, problem, unknown, jacobian):
        for column in range(m):
            unknown[column] += work.step[column]
    return SOLVED, error, marches
