"""Solvers of the predictive law's quadratic program, on programs that it made: `python -m tendond.offline.bench.qp`.

The solvers are those of PyPI that are installed: `pip install daqp quadprog osqp piqp proxsuite clarabel`. Each solves
every program from nothing, as a cycle does whose result must not depend on those before it.
"""

import importlib
import importlib.util
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.predictive import program
from tendond.daemon.control.predictive.program import Rows, Solution
from tendond.drivers.simulator.lockstep import closed_loop
from tendond.schemas.config.rig import check_config
from tendond.schemas.requests import ControlAction

Array = NDArray[np.float64]

CYCLES, ARMED = 160, 10
"""Cycles that are run, and the one that arms."""

HEADING = (
    "| solver | median us | p99 us | to DAQP | largest error of the cost | failed |\n"
    "| --- | --- | --- | --- | --- | --- |"
)


class Program(NamedTuple):
    """minimise 1/2 v'H v + f'v, lower <= A v <= upper; the first rows of A are the identity."""

    H: Array
    f: Array
    A: Array
    lower: Array
    upper: Array


def programs() -> list[Program]:
    """Record the programs of a jump within tight limits, many of which are met, and of the rest after it."""
    found: list[Program] = []
    solve = program.solve

    def record(hessian: Array, gradient: Array, low: Array, high: Array, rows: list[Rows], iterations: int) -> Solution:
        matrix = np.concatenate([np.eye(len(low)), *(one.matrix for one in rows)])
        lower = np.concatenate([low, *(one.lower for one in rows)])
        upper = np.concatenate([high, *(one.upper for one in rows)])
        found.append(Program(hessian.copy(), gradient.copy(), matrix, np.maximum(lower, -1e6), np.minimum(upper, 1e6)))
        return solve(hessian, gradient, low, high, rows, iterations)

    config = check_config(
        {
            "control": {"law": "mpc"},
            "reference": {"kind": "step", "across": 0.2, "branch": "below_135"},
            "pretension": {"duration": 0.3},
            "limits": {"displacement_rate": 0.08, "tension_rate": 200.0, "tension_max": 20.0},
        },
        "bench",
    )
    program.solve = record
    try:
        for _ in closed_loop(config, CYCLES, {ARMED: ControlAction.ARM}):
            pass
    finally:
        program.solve = solve
    return found


def _daqp(daqp: Any, p: Program) -> Array:
    return np.array(daqp.solve(p.H, p.f, p.A[len(p.f) :], p.upper, p.lower)[0])


def _quadprog(quadprog: Any, p: Program) -> Array:
    return np.array(quadprog.solve_qp(p.H, -p.f, np.vstack((p.A, -p.A)).T, np.concatenate((p.lower, -p.upper)))[0])


def _osqp(osqp: Any, p: Program) -> Array:
    sparse = importlib.import_module("scipy.sparse")
    solver = osqp.OSQP()
    solver.setup(
        sparse.csc_matrix(np.triu(p.H)), p.f, sparse.csc_matrix(p.A), p.lower, p.upper, verbose=False, eps_abs=1e-8,
        eps_rel=1e-8, max_iter=20000, adaptive_rho_interval=50,
    )  # fmt: skip
    return np.array(solver.solve().x)


def _piqp(piqp: Any, p: Program) -> Array:
    n = len(p.f)
    solver = piqp.DenseSolver()
    solver.setup(p.H, p.f, None, None, p.A[n:], p.lower[n:], p.upper[n:], p.lower[:n], p.upper[:n])
    solver.solve()
    return np.array(solver.result.x)


def _proxqp(proxsuite: Any, p: Program) -> Array:
    qp = proxsuite.proxqp.dense.QP(len(p.f), 0, len(p.A))
    qp.settings.eps_abs = 1e-8
    qp.init(p.H, p.f, None, None, p.A, p.lower, p.upper)
    qp.solve()
    return np.array(qp.results.x)


def _clarabel(clarabel: Any, p: Program) -> Array:
    sparse = importlib.import_module("scipy.sparse")
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    matrix, bound = sparse.csc_matrix(np.vstack((p.A, -p.A))), np.concatenate((p.upper, -p.lower))
    cone = [clarabel.NonnegativeConeT(len(bound))]
    return np.array(
        clarabel.DefaultSolver(sparse.csc_matrix(np.triu(p.H)), p.f, matrix, bound, cone, settings).solve().x
    )


SOLVERS: dict[str, tuple[str, Callable[[Any, Program], Array]]] = {
    "DAQP": ("daqp", _daqp),
    "quadprog": ("quadprog", _quadprog),
    "PIQP": ("piqp", _piqp),
    "ProxQP": ("proxsuite", _proxqp),
    "OSQP": ("osqp", _osqp),
    "Clarabel": ("clarabel", _clarabel),
}
"""Module and call of each; quadprog is Goldfarb's and Idnani's dual method, as qpOASES is an active-set method."""


def table(some: list[Program]) -> str:
    """Time the solvers that are installed in turns, in processor time, and return a Markdown table."""
    names = [name for name, (module, _) in SOLVERS.items() if importlib.util.find_spec(module) is not None]
    modules = {name: importlib.import_module(SOLVERS[name][0]) for name in names}
    times: dict[str, list[float]] = {name: [] for name in names}
    costs: dict[str, list[float]] = {name: [] for name in names}
    for one in some:
        for name in names:
            start = time.thread_time()
            try:
                change = SOLVERS[name][1](modules[name], one)
            except ValueError:  # quadprog's, of a program that it finds no solution of
                change = np.full(len(one.f), np.nan)
            times[name].append(1e6 * (time.thread_time() - start))
            reach = one.A @ change
            kept = bool(np.all(reach >= one.lower - 1e-5) and np.all(reach <= one.upper + 1e-5))
            cost = float(0.5 * change @ one.H @ change + one.f @ change)
            costs[name].append(cost if kept else np.nan)
    best = np.nanmin(np.array([costs[name] for name in names]), axis=0)
    lines = [HEADING]
    for name in names:
        middle, high = np.percentile(times[name], (50, 99))
        off = np.abs(np.array(costs[name]) - best) / np.maximum(np.abs(best), 1e-9)
        failed = int(np.isnan(off).sum())
        ratio = middle / float(np.median(times[names[0]]))
        lines.append(f"| {name} | {middle:.0f} | {high:.0f} | {ratio:.1f} | {np.nanmax(off):.0e} | {failed} |")
    return "\n".join(lines)


if __name__ == "__main__":
    recorded = programs()
    sizes = [one.A.shape for one in recorded]
    print(f"{len(recorded)} programs of {sizes[0][1]} unknowns, with up to {max(one[0] for one in sizes)} limits\n")
    print(table(recorded))
