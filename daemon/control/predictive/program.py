"""The quadratic program of a cycle, and its solution.

    minimise 1/2 v'H v + f'v    subject to    low <= v <= high,  lower <= R v <= upper

v are the changes of a plan, B m of them. The solver is DAQP, a dual active-set method (D. Arnström, A. Bemporad,
D. Axehill, "A dual active-set solver for embedded quadratic programming using recursive LDL' updates", IEEE Trans.
Autom. Control 67, 2022); docs/decisions/0007-qp-solver.md says why. It is bounded by iterations, not by a clock, so
that a cycle computes the same numbers again.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.errors import LawError

Array = NDArray[np.float64]

SOFT = 8
"""DAQP's flag of a constraint that may be violated at a price."""

INFEASIBLE, ITERATIONS_SPENT = -1, -4
"""DAQP's exit flags of a problem without a solution, and of one that takes more iterations than allowed."""

RELAXED_PRICE = 1e-6
"""Reciprocal weight of violated limits where not all can be kept: 1e-4 of a limit's unit costs as much as all else,
which is about 1e-2. A thousandth of it hides from DAQP that limits depend on each other: its pivots are rounded."""


@dataclass(frozen=True)
class Rows:
    """Linear limits of a plan's changes v: lower <= matrix v <= upper.

    Attributes:
        matrix: shape (r, v). lower, upper: shape (r,). soft: those that may be violated at a price, shape (r,).
    """

    matrix: Array
    lower: Array
    upper: Array
    soft: bool = False


class Solution(NamedTuple):
    """Changes of the plan.

    Attributes:
        change: v, shape (v,); zeros where none was found. cost: 1/2 v'H v + f'v.
        iterations: of the solver. active: number of limits that are met.
        relaxed: not all hard limits could be kept. found: there is a solution.
    """

    change: Array
    cost: float
    iterations: int
    active: int
    relaxed: bool
    found: bool


def solver() -> Callable[..., Any]:
    """Return DAQP's function `solve`.

    Raises:
        LawError: it is not installed.
    """
    try:
        from daqp import solve
    except ImportError:
        raise LawError(
            "control.law = 'mpc' needs the solver daqp, which is not installed: run pip install 'daqp>=0.11'"
        ) from None
    found: Callable[..., Any] = solve
    return found


def solve(hessian: Array, gradient: Array, low: Array, high: Array, rows: list[Rows], iterations: int) -> Solution:
    """Solve the program; where the hard limits contradict each other, with the smallest violations.

    Args:
        hessian: H, shape (v, v), positive definite. gradient: f, shape (v,).
        low, high: bounds of v, shape (v,). rows: further limits. iterations: largest number of the solver's.
    """
    # DAQP has room for as many met limits as there are unknowns and soft limits, and writes beyond it where rounding
    # hides that limits depend on each other. Each iteration meets one more at most, so empty soft rows, which it passes
    # over, make room for all iterations.
    room = max(0, iterations - len(low))
    matrix = np.concatenate([*(one.matrix for one in rows), np.zeros((room, len(low)))])
    upper = np.concatenate([high, *(one.upper for one in rows), np.ones(room)])
    lower = np.concatenate([low, *(one.lower for one in rows), -np.ones(room)])
    soft = np.zeros(len(upper), dtype=np.int32)
    soft[len(upper) - room :] = SOFT
    start = len(low)
    for one in rows:
        soft[start : start + len(one.upper)] = SOFT if one.soft else 0
        start += len(one.upper)
    spent, run = 0, solver()
    relaxed = soft.copy()
    relaxed[len(low) :] = SOFT
    for sense in (soft, relaxed):
        change, cost, flag, info = run(
            hessian, gradient, matrix, upper, lower, sense.copy(), iter_limit=iterations - spent, rho_soft=RELAXED_PRICE
        )
        spent += int(info["iterations"])
        if flag > 0 and bool(np.isfinite(change).all()):
            active = int(np.count_nonzero(info["lam"]))
            return Solution(np.array(change), float(cost), spent, active, sense is relaxed, True)
        if flag == ITERATIONS_SPENT or spent >= iterations:
            break
    return Solution(np.zeros(len(low)), 0.0, spent, 0, False, False)
