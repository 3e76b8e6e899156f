"""The boundary value problem of one step: shooting by a quasi-Newton method, in one compiled call.

Unknowns are the base load n(0), m(0), and in a displacement-driven rod the n tensions beside them. The raw map takes
all 6 + n of them to what is missing at the tip (6) and the tendons' path lengths (n); its Jacobian, a difference
Jacobian of eight-lane marches, is carried from step to step, kept up to date by Broyden's update and made anew when an
iteration contracts poorly. The same Jacobian gives the sensitivities.
"""

import math
from typing import Any, NamedTuple

from tendond.model.numerics.compile import borrowed, inlined, kernel
from tendond.model.numerics.linear import solve_in_place
from tendond.model.solver.march import STATE, march
from tendond.model.solver.work import LANES, Work

SOLVED, DIVERGED = 0, 1

CONTRACTION_WANTED = 0.5  # of the residual in one iteration; a poorer one makes the Jacobian anew


class RodData(NamedTuple):
    """What does not change while a rod is simulated. `one` and `many` have as many entries as lanes march together."""

    one: tuple[int, ...]
    many: tuple[int, ...]
    x: tuple[float, ...]  # tendon positions [m]
    y: tuple[float, ...]
    constants: Any
    tableau: Any
    weights: Any
    push: Any  # how a push is spread over the stages [1/m]
    flags: tuple[bool, bool]
    steps: int
    ds: float
    length: float
    stiffness: float  # of a tendon [N/m]
    tolerance: float  # residual norm [N, N m]
    budget: int  # marches that one solve may spend


@inlined
def borrowed_rod(rod: RodData) -> RodData:
    """The same rod, its arrays borrowed."""
    return RodData(
        rod.one, rod.many, rod.x, rod.y, borrowed(rod.constants), borrowed(rod.tableau), borrowed(rod.weights),
        borrowed(rod.push), rod.flags, rod.steps, rod.ds, rod.length, rod.stiffness, rod.tolerance, rod.budget,
    )  # fmt: skip


@inlined
def evaluate(
    rod: RodData, work: Work, c0: float, unknown: Any, loads: Any, history: Any, levels: Any, geometry: Any, raw: Any
) -> None:
    """One shot: raw(unknown) = (missing tip force and moment, tendon lengths)."""
    n = len(rod.x)
    march(
        rod.one, rod.x, rod.y, rod.constants, rod.tableau, rod.weights, rod.flags, rod.steps, rod.ds, c0,
        unknown[:6], unknown[6:], loads[n:], rod.push, history, levels, geometry, work.march, work.node, work.length,
        work.residual,
    )  # fmt: skip
    for j in range(6):
        raw[j] = work.residual[j]
    for i in range(n):
        raw[6 + i] = work.length[i]


@inlined
def differentiate(
    rod: RodData, work: Work, c0: float, unknown: Any, raw: Any, columns: int, loads: Any, history: Any, levels: Any,
    geometry: Any, jacobian: Any,
) -> int:  # fmt: skip
    """First `columns` columns of the raw map's Jacobian at `unknown`, by differences, and the tip's; returns marches.

    `work.node` must hold the last node of the shot at `unknown`.
    """
    n = len(rod.x)
    for j in range(STATE):
        for column in range(columns):
            work.tip[j, column] = work.node[j]
    marches = 0
    for start in range(0, columns, LANES):
        count = min(LANES, columns - start)
        for j in range(6):
            for lane in range(LANES):
                work.base[j * LANES + lane] = unknown[j]
        for i in range(n):
            for lane in range(LANES):
                work.tension[i * LANES + lane] = unknown[6 + i]
        for lane in range(count):
            column = start + lane
            if column < 6:
                work.base[column * LANES + lane] += perturbation(work, unknown, column)
            else:
                work.tension[(column - 6) * LANES + lane] += perturbation(work, unknown, column)
        march(
            rod.many, rod.x, rod.y, rod.constants, rod.tableau, rod.weights, rod.flags, rod.steps, rod.ds, c0,
            work.base, work.tension, loads[n:], rod.push, history, levels, geometry, work.march, work.node, work.length,
            work.residual,
        )  # fmt: skip
        for lane in range(count):
            column = start + lane
            inverse = 1.0 / perturbation(work, unknown, column)
            for j in range(6):
                jacobian[j, column] = (work.residual[j * LANES + lane] - raw[j]) * inverse
            for i in range(n):
                jacobian[6 + i, column] = (work.length[i * LANES + lane] - raw[6 + i]) * inverse
            for j in range(STATE):
                work.tip[j, column] = (work.node[j * LANES + lane] - work.tip[j, column]) * inverse
        marches += 1
    return marches


@inlined
def perturbation(work: Work, unknown: Any, column: int) -> float:
    """Difference step: 1e-7 of the load, and of 1 N or 0.05 N m where it vanishes."""
    return float(1e-7 * (work.scale[column] + abs(unknown[column])))


@inlined
def _error(rod: RodData, displacement_driven: bool, unknown: Any, raw: Any, loads: Any) -> float:
    """Norm of what is missing [N, N m]: at the tip, and in the tendons' law T = max(0, k (d_commanded - d))."""
    total = 0.0
    for j in range(6):
        total += raw[j] * raw[j]
    if displacement_driven:
        for i in range(len(rod.x)):
            missing = unknown[6 + i] - max(0.0, pull(rod, raw, loads, i))
            total += missing * missing
    return float(math.sqrt(total))


@inlined
def pull(rod: RodData, raw: Any, loads: Any, i: int) -> float:
    """k (d_commanded - d): tension of tendon i where it is positive [N]."""
    return float(rod.stiffness * (loads[i] - rod.length + raw[6 + i]))


@inlined
def newton_matrix(rod: RodData, work: Work, displacement_driven: bool, raw: Any, loads: Any, jacobian: Any) -> int:
    """Fill `work.matrix` with the equations' Jacobian and return their number; a slack tendon's equation is T = 0."""
    n = len(rod.x)
    m = 6 + n if displacement_driven else 6
    for j in range(6):
        for column in range(m):
            work.matrix[j, column] = jacobian[j, column]
    for row in range(6, m):
        stiffness = rod.stiffness if pull(rod, raw, loads, row - 6) > 0.0 else 0.0
        for column in range(m):
            work.matrix[row, column] = -stiffness * jacobian[row, column]
        work.matrix[row, row] += 1.0
    return m


@inlined
def _newton_step(
    rod: RodData, work: Work, displacement_driven: bool, unknown: Any, raw: Any, loads: Any, jacobian: Any
) -> bool:
    """Solve for the (semismooth) Newton step into `work.step`; False where the equations are singular."""
    m = newton_matrix(rod, work, displacement_driven, raw, loads, jacobian)
    for j in range(6):
        work.step[j] = -raw[j]
    for row in range(6, m):
        work.step[row] = max(0.0, pull(rod, raw, loads, row - 6)) - unknown[row]
    return bool(solve_in_place(work.matrix, work.step, m))


@inlined
def _broyden(work: Work, m: int, raw: Any, raw_trial: Any, jacobian: Any) -> None:
    """Broyden's rank-one update of the raw Jacobian, from the step taken and what it changed."""
    square = 0.0
    for column in range(m):
        square += (work.step[column] / work.scale[column]) ** 2
    if square == 0.0:
        return
    for j in range(m):
        defect = raw_trial[j] - raw[j]
        for column in range(m):
            defect -= jacobian[j, column] * work.step[column]
        defect /= square
        for column in range(m):
            jacobian[j, column] += defect * work.step[column] / work.scale[column] ** 2


@kernel
def solve(
    rod: RodData, work: Work, c0: float, displacement_driven: bool, unknown: Any, loads: Any, history: Any, levels: Any,
    geometry: Any, jacobian: Any,
) -> tuple[int, float, int]:  # fmt: skip
    """Solve for `unknown`, from the guess that it holds.

    Args:
        rod: the rod.
        work: its scratch memory.
        c0: of BDF-alpha [1/s], 0 in statics.
        displacement_driven: the first n loads are commanded displacements [m] rather than tensions [N].
        unknown: guess in, solution out: n(0), m(0), T; shape (6 + n,).
        loads: commanded displacements (or tensions), tip force, tip moment, distributed force, distributed moment;
            shape (n + 15,).
        history: y_h, shape (stages, 18).
        levels, geometry: the solution, see `march.march`.
        jacobian: guess in (all zero: none), last one out, shape (6 + n, 6 + n).

    Returns:
        SOLVED or DIVERGED, the residual's norm, marches spent (one for each call of `march`).
    """
    n = len(rod.x)
    m = 6 + n if displacement_driven else 6
    if not displacement_driven:
        for i in range(n):
            unknown[6 + i] = loads[i]
    evaluate(rod, work, c0, unknown, loads, history, levels, geometry, work.raw)
    marches = 1
    error = _error(rod, displacement_driven, unknown, work.raw, loads)
    fresh = False  # the Jacobian was made at `unknown`
    poor = jacobian[0, 0] == 0.0  # the Jacobian has to be made anew
    moved = False  # the last march was not the one at `unknown`
    factor = 1.0  # of the Newton step
    while error > rod.tolerance:
        if marches >= rod.budget or factor < 1e-3:
            return DIVERGED, error, marches
        if poor and not fresh:
            if moved:
                evaluate(rod, work, c0, unknown, loads, history, levels, geometry, work.raw)
                marches += 1
            marches += differentiate(rod, work, c0, unknown, work.raw, m, loads, history, levels, geometry, jacobian)
            fresh, poor = True, False
        solvable = _newton_step(rod, work, displacement_driven, unknown, work.raw, loads, jacobian)
        if not solvable and fresh:
            return DIVERGED, error, marches
        for column in range(m):
            work.step[column] *= factor
            work.trial[column] = unknown[column] + work.step[column]
        for column in range(m, 6 + n):
            work.trial[column] = unknown[column]
        evaluate(rod, work, c0, work.trial, loads, history, levels, geometry, work.raw_trial)
        marches += 1
        trial_error = _error(rod, displacement_driven, work.trial, work.raw_trial, loads)
        if solvable and (trial_error <= rod.tolerance or trial_error < (1.0 - 0.1 * factor) * error):
            _broyden(work, m, work.raw, work.raw_trial, jacobian)
            for column in range(6 + n):
                unknown[column] = work.trial[column]
                work.raw[column] = work.raw_trial[column]
            poor = trial_error > CONTRACTION_WANTED * error
            fresh = moved = False
            factor = 1.0
            error = trial_error
        else:
            moved = poor = True
            if fresh:
                factor *= 0.3
    if not error <= rod.tolerance:  # NaN
        return DIVERGED, error, marches
    if jacobian[0, 0] != 0.0 and _newton_step(rod, work, displacement_driven, unknown, work.raw, loads, jacobian):
        for column in range(m):
            unknown[column] += work.step[column]
    return SOLVED, error, marches
