"""Benchmark of the general rod beside the shooting rod: steps, statics, derivatives, many at once; in one run.

The motion is that of `rod`: tensions of 3 +- 2 N, sines of 0.5 Hz that are a part of a period apart, gravity across.
Times are of one call from Python. The solvers take turns, so that a busy machine slows all of them alike: what counts
is a ratio.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tendond.model import Rod, RodParameters
from tendond.model.strain import Robot, Section, StrainRod, StrainState, Tendon
from tendond.model.strain.derivatives.linearise import Linearisation
from tendond.model.strain.derivatives.results import InputSensitivity, StepSensitivity
from tendond.model.strain.stepping.scratch import Loads
from tendond.offline.bench.general_rod.batch import bench_batch
from tendond.offline.bench.general_rod.batch import robot as one_section

Array = NDArray[np.float64]

STEPS = 200
REPEATS = 5
BATCH = 200
TIME_STEP, SHORT = 0.01, 0.001

MORE = "on top of a step"
BY_INPUTS = f"{MORE}, tip and tendons by actuation and force"
LINEAR_MODEL = f"{MORE}, its whole linear model"
"""Rows of what derivatives take."""

FRICTION = 0.1
WITH_FRICTION = f"one section, 4 tendons, mu = {FRICTION:g}: 10 ms"

Run = Callable[[], Array]
"""Times of calls [s], shape (k,)."""

Advance = Callable[[StrainState, Loads], StrainState]


@dataclass(frozen=True)
class GeneralRow:
    """A line of the table.

    Attributes:
        name: what is timed. median_us, p99_us: time of a call [us].
        to_shooting: ratio to a step of the shooting rod of 10 ms. to_step: ratio to a step of the same robot; NaN where
            it is that step.
    """

    name: str
    median_us: float
    p99_us: float
    to_shooting: float
    to_step: float


def three_sections() -> Robot:
    """Return an arm of three nitinol sections with three tendons each."""
    wire = Section.round(0.15, 6e-4, 60e9, 8000.0, bending_damping=(1e-5,) * 3)
    tendons = []
    for section in range(3):
        for index in range(3):
            at = 2.0 * math.pi * (index / 3.0 + section / 9.0)
            tendons.append(Tendon(0.15 * (section + 1), (0.008 * math.cos(at), 0.008 * math.sin(at)), 2e4))
    return Robot((wire,) * 3, tuple(tendons), (), (-9.81, 0.0, 0.0))


def tensions(step: int, time_step: float, count: int) -> Array:
    """Tensions of the motion [N], shape (count,)."""
    phases = 2.0 * np.pi * np.arange(count) / count
    return np.asarray(3.0 + 2.0 * np.sin(2.0 * np.pi * 0.5 * step * time_step + phases)) * (4.0 / count)


def bench_general(
    progress: Callable[[str], None] = lambda name: None, steps: int = STEPS, batch: int = BATCH
) -> list[GeneralRow]:
    """Return every row; `progress` is called with the name of the next one. Takes about 10 s."""
    robots = {"one section, 4 tendons": one_section(), "three sections, 9 tendons": three_sections()}
    runs: dict[str, Run] = {"shooting rod, 10 ms": _shooting(steps)}
    for name, robot in robots.items():
        rod, short = StrainRod(robot, TIME_STEP), StrainRod(robot, SHORT)
        linear = Linearisation(rod)
        runs[f"{name}: 10 ms"] = _along(rod, steps, rod.step)
        runs[f"{name}: 1 ms"] = _along(short, steps, short.step)
        runs[f"{name}: statics from a neighbour"] = _along(rod, steps, _statics(rod))
        runs[f"{name}: {BY_INPUTS}"] = _along(rod, steps, _states(linear.inputs))
        runs[f"{name}: {LINEAR_MODEL}"] = _along(rod, steps, _states(linear.step))
    plain = one_section()
    rubbing = replace(plain, tendons=tuple(replace(one, friction=FRICTION) for one in plain.tendons))
    rod = StrainRod(rubbing, TIME_STEP)
    runs[WITH_FRICTION] = _along(rod, steps, rod.step)
    found: dict[str, list[Array]] = {name: [] for name in runs}
    for _ in range(REPEATS):
        for name, run in runs.items():
            progress(name)
            found[name].append(run())
    times = {name: 1e6 * np.concatenate(one) for name, one in found.items()}
    shooting = float(np.median(times["shooting rod, 10 ms"]))
    rows = [_row(name, one, shooting, math.nan) for name, one in times.items() if MORE not in name]
    own = float(np.median(times["one section, 4 tendons: 10 ms"]))
    rubbed = times[WITH_FRICTION]
    rows[-1] = _row(WITH_FRICTION, rubbed, shooting, float(np.median(rubbed)) / own)
    for robot_name in robots:
        step = float(np.median(times[f"{robot_name}: 10 ms"]))
        for what in (BY_INPUTS, LINEAR_MODEL):
            more = float(np.median(times[f"{robot_name}: {what}"])) - step
            rows.append(GeneralRow(f"{robot_name}: {what}", more, math.nan, more / shooting, more / step))
    progress("many at once")
    many = bench_batch(batch).step_us
    rows.append(GeneralRow(f"{batch} rods at once: a step", many, math.nan, many / shooting, many / own))
    return rows


def _row(name: str, times: Array, shooting: float, to_step: float) -> GeneralRow:
    median = float(np.median(times))
    return GeneralRow(name, median, float(np.percentile(times, 99)), median / shooting, to_step)


def _timed(calls: int, call: Callable[[int], None]) -> Array:
    times = np.zeros(calls)
    for k in range(calls):
        begin = time.perf_counter()
        call(k)
        times[k] = time.perf_counter() - begin
    return times


def _statics(rod: StrainRod) -> Advance:
    return lambda state, loads: rod.solve_static(loads, state)


def _states(derive: Callable[[StrainState, Loads], StepSensitivity | InputSensitivity]) -> Advance:
    return lambda state, loads: derive(state, loads).state


def _shooting(steps: int) -> Run:
    rod = Rod(RodParameters())
    loads = [rod.loads(tensions(k, TIME_STEP, 4)) for k in range(steps + 1)]
    start = rod.solve_static(tensions(0, TIME_STEP, 4))
    rod.advance(start.copy(), loads[1], False)  # to warm up: a rod's first step loads its kernel

    def run() -> Array:
        state = start.copy()
        return _timed(steps, lambda k: rod.advance(state, loads[k + 1], False))

    return run


def _along(rod: StrainRod, steps: int, advance: Advance) -> Run:
    """Return the run of a rod along the motion, by a method that returns the next state."""
    loads = [rod.loads(tensions(k, rod.time_step, len(rod.robot.tendons))) for k in range(steps + 1)]
    start = rod.solve_static(loads[0])
    advance(start, loads[1])

    def run() -> Array:
        state = start

        def call(k: int) -> None:
            nonlocal state
            state = advance(state, loads[k + 1])

        return _timed(steps, call)

    return run
