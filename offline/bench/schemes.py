"""Comparison of space schemes: error of the tip against the converged solution, time of a step, number of nodes.

Candidates that are not registered schemes are defined here, so that the comparison can be repeated.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model import Rod, RodParameters
from tendond.model.solver.schemes import EULER, RK4, RK6, Scheme
from tendond.offline.bench.rod import tensions

Array = NDArray[np.float64]

FINE_NODES = 101
TIMED_STEPS = 300
REPEATS = 3


def _candidate(
    name: str, rows: tuple[tuple[float, ...], ...], weights: tuple[float, ...], order: int, source: str
) -> Scheme:
    size = len(weights)
    tableau = tuple(row + (0.0,) * (size - len(row)) for row in rows)
    return Scheme(name, tableau, weights, order, 11, orthonormal=True, trapezoidal=False, source=source)


MIDPOINT = _candidate("midpoint", ((), (0.5,)), (0.0, 1.0), 2, "Runge 1895")
RALSTON3 = _candidate("ralston3", ((), (0.5,), (0.0, 0.75)), (2 / 9, 1 / 3, 4 / 9), 3, "Ralston 1962")
BUTCHER5 = _candidate(
    "butcher5",
    (
        (),
        (1 / 4,),
        (1 / 8, 1 / 8),
        (0.0, 0.0, 1 / 2),
        (3 / 16, -3 / 8, 3 / 8, 9 / 16),
        (-3 / 7, 8 / 7, 6 / 7, -12 / 7, 8 / 7),
    ),
    (7 / 90, 0.0, 32 / 90, 12 / 90, 32 / 90, 7 / 90),
    5,
    "Butcher 1964",
)

LADDER: tuple[tuple[Scheme, tuple[int, ...]], ...] = (
    (EULER, (200, 800)),
    (MIDPOINT, (41, 101)),
    (RALSTON3, (17, 21)),
    (RK4, (9, 11, 13, 17)),
    (BUTCHER5, (6, 7, 8)),
    (RK6, (5, 6, 7, 8)),
)

STATIC_CASES: dict[str, dict[str, Any]] = {
    "10 N": {"tensions": (10.0, 0.0, 0.0, 0.0)},
    "43 N": {"tensions": (43.0, 0.0, 0.0, 0.0)},
    "[5, 4, 1, 1] N": {"tensions": (5.0, 4.0, 1.0, 1.0)},
    "half a turn": {"tensions": (47.5, 0.0, 0.0, 0.0)},
    "60 N": {"tensions": (60.0, 0.0, 0.0, 0.0)},
    "43 N, 50 g": {"tensions": (43.0, 0.0, 0.0, 0.0), "tip_force": (-0.4905, 0.0, 0.0)},
    "in space": {"tensions": (30.0, 20.0, 5.0, 1.0), "tip_force": (0.3, -0.4, 0.2)},
}
"""Loads of the static cases; gravity acts in all of them."""


@dataclass(frozen=True)
class SchemeRow:
    """A line: greatest static error and greatest error in a step to 43 N [mm]; median time of a step [us]."""

    scheme: str
    nodes: int
    evaluations: int
    static_mm: float
    dynamic_mm: float
    median_us: float


def compare_schemes(progress: Callable[[str], None] = lambda name: None) -> list[SchemeRow]:
    """Time every scheme in turn, so that all of them run under the same conditions."""
    progress("converged solution")
    static, dynamic = _tips(Rod(RodParameters(), RK6, FINE_NODES, tolerance=1e-9))
    rods = [(scheme, nodes, Rod(RodParameters(), scheme, nodes)) for scheme, ladder in LADDER for nodes in ladder]
    errors = []
    for scheme, nodes, _ in rods:
        progress(f"error of {scheme.name}, {nodes} nodes")
        ours_static, ours_dynamic = _tips(Rod(RodParameters(), scheme, nodes, tolerance=1e-9))
        errors.append(
            tuple(
                1e3 * float(np.linalg.norm(ours - exact, axis=1).max())
                for ours, exact in ((ours_static, static), (ours_dynamic, dynamic))
            )
        )
    best = np.full((len(rods), TIMED_STEPS), np.inf)
    for _ in range(REPEATS):
        for k, (scheme, nodes, rod) in enumerate(rods):
            progress(f"time of {scheme.name}, {nodes} nodes")
            best[k] = np.minimum(best[k], _times(rod))
    return [
        SchemeRow(
            scheme.name,
            nodes,
            (nodes - 1) * len(scheme.weights) + 1,
            error[0],
            error[1],
            1e6 * float(np.median(times)),
        )
        for (scheme, nodes, _), error, times in zip(rods, errors, best, strict=True)
    ]


def _tips(rod: Rod) -> tuple[Array, Array]:
    """Compute the tips of every static case, and along a step from rest to 43 N and on to three tendons."""
    static = [rod.tip(rod.solve_static(**case)).position for case in STATIC_CASES.values()]
    state = rod.solve_static()
    dynamic = []
    for step in range(60):
        state = rod.step(state, (43.0, 0.0, 0.0, 0.0) if step < 30 else (20.0, 0.0, 15.0, 10.0))
        dynamic.append(rod.tip(state).position)
    return np.array(static), np.array(dynamic)


def _times(rod: Rod) -> Array:
    """Time the steps of a smooth motion [s]."""
    state = rod.solve_static(tensions(0))
    times = np.zeros(TIMED_STEPS)
    for k in range(TIMED_STEPS):
        loads = rod.loads(tensions(k + 1))
        begin = time.perf_counter()
        rod.advance(state, loads)
        times[k] = time.perf_counter() - begin
    return times


def markdown(rows: list[SchemeRow]) -> str:
    """Return the table as Markdown."""
    euler = next(row.median_us for row in rows if row.scheme == EULER.name)
    lines = [
        "| scheme | nodes | evaluations | static error mm | dynamic error mm | step us | to euler 200 |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    lines += [
        f"| {row.scheme} | {row.nodes} | {row.evaluations} | {row.static_mm:.4f} | {row.dynamic_mm:.4f} "
        f"| {row.median_us:.1f} | {row.median_us / euler:.2f} |"
        for row in rows
    ]
    return "\n".join(lines)
