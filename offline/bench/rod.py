"""Benchmark of the rod: time of a step and error of the tip; one motion, every solver, in one run.

The motion: four tendons at 3 +- 2 N, sines of 0.5 Hz a quarter period apart, gravity across, 10 s of 10 ms steps.
Times are of one call from Python, every one of them: median, p99 and max are over all steps of all runs, under
whatever load.
"""

import importlib
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import tendond
from tendond.model import Rod, RodParameters

Array = NDArray[np.float64]

STEPS = 1000
STATIC_STEPS = 200
REFERENCE_STEPS = 3
REPEATS = 3
TIME_STEP = 0.01
FINE_NODES = 49


@dataclass(frozen=True)
class RodRow:
    """A line of the table.

    Attributes:
        name: the solver's name.
        median_us, p99_us, max_us: time of a step [us].
        passes_per_step: marches along the rod, mean.
        tip_error_mm: greatest distance from the converged solution's tip [mm].
    """

    name: str
    median_us: float
    p99_us: float
    max_us: float
    passes_per_step: float
    tip_error_mm: float


@dataclass(frozen=True)
class _TimedRun:
    times: Array  # (k,) [s]
    marches: Array  # (k,)
    tips: Array  # (k, 3) [m]


def tensions(step: int) -> Array:
    """Tensions of the motion [N], shape (4,)."""
    return np.asarray(3.0 + 2.0 * np.sin(2.0 * np.pi * 0.5 * step * TIME_STEP + np.arange(4) * np.pi / 2.0))


def bench_rod(progress: Callable[[str], None] = lambda name: None) -> list[RodRow]:
    """Every row; `progress` is called with the name of the next one. Takes about 15 s."""
    parameters = RodParameters()
    fine = Rod(parameters, nodes=FINE_NODES)
    progress("converged solution")
    states = [fine.solve_static(tensions(0))]
    for step in range(1, STEPS + 1):
        states.append(fine.step(states[-1], tensions(step)))
    exact = np.array([fine.tip(state).position for state in states])
    pulled = np.array([fine.displacements(state, elastic=True) for state in states])

    def static_exact() -> Array:
        return np.array([fine.tip(fine.solve_static(tensions(step))).position for step in range(1, STATIC_STEPS + 1)])

    solvers: dict[str, tuple[Callable[[], _TimedRun], Callable[[], Array]]] = {
        "euler_n200": (lambda: _dynamic(Rod(parameters, "euler", 200)), lambda: exact[1:]),
        "default": (lambda: _dynamic(Rod(parameters)), lambda: exact[1:]),
        "default_displacement": (lambda: _dynamic(Rod(parameters), pulled), lambda: exact[1:]),
        "static": (lambda: _static(Rod(parameters)), static_exact),
    }
    rows = []
    for name, (run, truth) in solvers.items():
        progress(name)
        runs = [run() for _ in range(REPEATS)]
        rows.append(_row(name, runs, truth()))
    progress("reference")
    rows += [_row("reference", [run], exact[1 : REFERENCE_STEPS + 1]) for run in _reference()]
    return rows


def _row(name: str, runs: list[_TimedRun], truth: Array) -> RodRow:
    times = np.concatenate([run.times for run in runs]) * 1e6
    return RodRow(
        name=name,
        median_us=float(np.median(times)),
        p99_us=float(np.percentile(times, 99)),
        max_us=float(times.max()),
        passes_per_step=float(np.mean(runs[0].marches)),
        tip_error_mm=float(np.linalg.norm(runs[0].tips - truth, axis=1).max()) * 1e3,
    )


def _dynamic(rod: Rod, displacements: Array | None = None) -> _TimedRun:
    """The motion, driven by tension, or by the given displacements [m], shape (STEPS + 1, 4)."""
    driven = displacements is not None
    actuation = np.array([tensions(step) for step in range(STEPS + 1)]) if displacements is None else displacements
    loads = np.array([rod.loads(commands) for commands in actuation])
    start = {"displacements" if driven else "tensions": actuation[0]}
    state = rod.solve_static(**start)
    rod.advance(state.copy(), loads[1], driven)  # to warm up: a rod's first step loads its kernel
    times, marches, tips = np.zeros(STEPS), np.zeros(STEPS), np.zeros((STEPS, 3))
    for k in range(STEPS):
        begin = time.perf_counter()
        rod.advance(state, loads[k + 1], driven)
        times[k] = time.perf_counter() - begin
        marches[k], tips[k] = state.marches, rod.tip(state).position
    return _TimedRun(times, marches, tips)


def _static(rod: Rod) -> _TimedRun:
    """Equilibria along the motion, each from the one before."""
    state = rod.solve_static(tensions(0))
    times, marches, tips = np.zeros(STATIC_STEPS), np.zeros(STATIC_STEPS), np.zeros((STATIC_STEPS, 3))
    for k in range(STATIC_STEPS):
        begin = time.perf_counter()
        state = rod.solve_static(tensions(k + 1), start=state)
        times[k] = time.perf_counter() - begin
        marches[k], tips[k] = state.marches, rod.tip(state).position
    return _TimedRun(times, marches, tips)


def _reference() -> Iterator[_TimedRun]:
    """The plain implementation, which is part of the tests: nothing where they are not installed."""
    root = Path(tendond.__file__).resolve().parent.parent
    if not (root / "tests" / "reference").is_dir():
        return
    sys.path.insert(0, str(root))
    try:
        reference: Any = importlib.import_module("tests.reference")
    except ImportError:  # SciPy is a development dependency
        return
    finally:
        sys.path.remove(str(root))
    model = reference.ReferenceModel(reference.ReferenceRod(), reference.euler(200))
    solution = model.solve_static(tensions(0))
    times, tips = np.zeros(REFERENCE_STEPS), np.zeros((REFERENCE_STEPS, 3))
    marches = np.full(REFERENCE_STEPS, np.nan)
    for k in range(REFERENCE_STEPS):
        begin = time.perf_counter()
        solution = model.step(solution, tensions(k + 1))
        times[k] = time.perf_counter() - begin
        tips[k] = solution.tip.position
    yield _TimedRun(times, marches, tips)


def as_json(rows: Sequence[Any]) -> list[dict[str, Any]]:
    """Return rows as plain data; what is not counted is null."""
    return [{key: None if value != value else value for key, value in asdict(row).items()} for row in rows]
