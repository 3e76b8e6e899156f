"""Running the scenarios: in lockstep, through the same `cycle.step` that runs live, in a pool of processes."""

import multiprocessing
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.reference.planar import PLANES
from tendond.daemon.errors import DaemonError
from tendond.drivers.simulator.lockstep import Watched, watched_loop
from tendond.model.rod.static_curve import StaticCurve, static_curve
from tendond.model.rods.selection import rod_from_section
from tendond.offline.logs.metrics import Metrics, metrics, tracking_of
from tendond.offline.paper.scenarios import ARMED, Scenario
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.robot import RodSection
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PaperRun:
    """A scenario that was run; k samples, sample i is iteration i.

    Attributes:
        scenario: the scenario.
        metrics: metrics of the measured tip.
        tip: measured [m], shape (k, 3).
        reference: reference of the tip [m], shape (k, 3).
        target: end of the reference [m], shape (3,).
        displacement: commanded displacement of the agonist [m], shape (k,).
        tension: commanded [N], shape (k, n).
        tip_force: force on the plant's tip [N], shape (k, 3).
        force: the observer's estimate of it [N], shape (k, 3).
        shapes: shapes of the plant's rod [m], shape (k, points, 3).
        lyapunov: V of the law, shape (k,).
        errors: the vectors whose squares make 2 V, in the plane, shape (k, m, 2).
        limited: a limit held the command back, shape (k,).
        furthest: greatest x of a rod at rest [m], without load, as the controller knows it.
        ending: why the run left the tracking mode; empty if it did not.
    """

    scenario: Scenario
    metrics: Metrics
    tip: Array
    reference: Array
    target: Array
    displacement: Array
    tension: Array
    tip_force: Array
    force: Array
    shapes: Array
    lyapunov: Array
    errors: Array
    limited: NDArray[np.bool_]
    furthest: float
    ending: str

    @property
    def law(self) -> str:
        """Law of the controller."""
        return self.scenario.law


Runs = dict[tuple[str, str], PaperRun]
"""Runs by the scenario's name and law."""

POINTS = 41
"""Points of a shape."""

ERRORS = {"backstepping": ("z1", "z2"), "sliding_mode": ("surface",)}
"""Terms of each law whose squares make 2 V."""


def run_scenario(scenario: Scenario) -> PaperRun:
    """Run it to its end.

    Raises:
        DaemonError: it did not start to track when it should.
        ConvergenceError: the plant has no solution.
    """
    config, start = scenario.config, scenario.start
    watched = list(watched_loop(config, start + scenario.iterations, {ARMED: ControlAction.ARM}, POINTS))
    records = [one.record for one in watched]
    series = tracking_of(records, config, scenario.name)
    if int(series.ticks[0]) != start:
        raise DaemonError(
            f"scenario {scenario.name}: tracks from tick {series.ticks[0]} on, not {start}; its loads come too early "
            "or late, check pretension.duration and scenarios.ARMED"
        )
    curve = _curve(config)
    part = watched[start : start + len(series.ticks)]
    return PaperRun(
        scenario=scenario,
        metrics=metrics(series, curve),
        tip=series.tip,
        reference=series.reference,
        target=np.array(series.target),
        displacement=series.displacement[:, series.agonist],
        tension=series.tension,
        tip_force=np.array([one.truth.tip_force for one in part]),
        force=np.array([one.record.observer.force for one in part]),
        shapes=np.array([one.shape for one in part]),
        lyapunov=np.array([_term(one, "lyapunov") for one in part]),
        errors=np.array([[_term(one, name) for name in ERRORS[scenario.law]] for one in part]),
        limited=np.array([bool(one.record.limited) for one in part]),
        furthest=float(curve.spline(curve.arc)[:, 0].max()),
        ending="" if records[-1].mode is Mode.TRACKING else f"{records[-1].mode.value}: {records[-1].reason}",
    )


def run_all(scenarios: Sequence[Scenario], pool: Executor, done: Callable[[str], None]) -> Runs:
    """Run scenarios in a pool.

    Args:
        scenarios: the scenarios.
        pool: the pool.
        done: called with the name of each finished run.
    """
    futures = {pool.submit(run_scenario, scenario): scenario for scenario in scenarios}
    for future in as_completed(futures):
        future.result()
        done(f"{futures[future].name}, {futures[future].law.replace('_', ' ')}")
    return {(run.scenario.name, run.law): run for run in (future.result() for future in futures)}


@contextmanager
def process_pool(processes: int | None = None) -> Iterator[ProcessPoolExecutor]:
    """Open a pool of spawned processes: a fork would copy the threads of a progress bar with their locks."""
    # Ctrl-C is for the parent alone, which then ends them.
    with ProcessPoolExecutor(
        processes, multiprocessing.get_context("spawn"), signal.signal, (signal.SIGINT, signal.SIG_IGN)
    ) as pool:
        try:
            yield pool
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _term(one: Watched, name: str) -> float | tuple[float, ...]:
    """Return a term of the law; NaN in a cycle in which it did not decide."""
    terms = one.record.terms
    return terms[name] if terms else (float("nan") if name == "lyapunov" else (float("nan"), float("nan")))


def _curve(config: RigConfig) -> StaticCurve:
    """Compute the controller's curve of resting tips."""
    return _curve_of(
        config.rod.model_dump_json(),
        config.loop.period,
        config.control.agonist,
        config.limits.tension_max,
        PLANES[config.control.plane],
    )


@lru_cache(maxsize=8)
def _curve_of(rod: str, period: float, agonist: int, tension_max: float, axes: tuple[int, int]) -> StaticCurve:
    return static_curve(rod_from_section(RodSection.model_validate_json(rod), period), agonist, tension_max, axes)
