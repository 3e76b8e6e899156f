"""Benchmark of many rods at once: steps per second over threads, and whether they are those of rods one by one."""

import os
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from tendond.model.strain import Body, Robot, Section, StrainRod, Tendon
from tendond.model.strain.batch import RodBatch
from tendond.schemas.paper_robot import (
    BENDING_DAMPING,
    DENSITY,
    DRAG,
    GRAVITY,
    LENGTH,
    RADIUS,
    TENDON_POSITIONS,
    YOUNGS_MODULUS,
)

TIME_STEP = 0.01
STEPS = 100
BLOCK = 10
CHECKED = 5
GOAL_RODS, GOAL_SECONDS = 100_000, 90.0


@dataclass(frozen=True)
class BatchRow:
    """Figures of a run.

    Attributes:
        rods, threads: of the run. seconds: for 1 s of motion of all rods.
        step_us: processor time of a step of a rod [us]: what it takes on a core of its own.
        goal_seconds: for 10^5 rods on as many cores as threads, by that; the goal is 90 s on two.
        minima: steps that ended in a minimum. equal: whether rods stepped one by one end in the same bits.
    """

    rods: int
    threads: int
    seconds: float
    step_us: float
    goal_seconds: float
    minima: int
    equal: bool


def robot(stiffness: float = 1.0) -> Robot:
    """Return the paper's robot with a factor on Young's modulus, elastic tendons and a marker body."""
    modulus = YOUNGS_MODULUS * stiffness
    section = Section.round(LENGTH, RADIUS, modulus, DENSITY, bending_damping=BENDING_DAMPING, drag=DRAG)
    tendons = tuple(Tendon(LENGTH, one, 2e4) for one in TENDON_POSITIONS)
    return Robot((section,), tendons, (Body(LENGTH, 0.005),), GRAVITY)


def bench_batch(rods: int, threads: int | None = None) -> BatchRow:
    """Time 1 s of motion of `rods` rods of 20 different stiffnesses, each with its own smooth tensions."""
    count = threads or len(os.sched_getaffinity(0))
    kinds = [robot(0.9 + 0.01 * k) for k in range(20)]
    batch = RodBatch([kinds[i % len(kinds)] for i in range(rods)], TIME_STEP, count)
    phases = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, (rods, 1))

    def tensions(first: int) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        at = TIME_STEP * np.arange(first, first + BLOCK)[:, None, None]
        quarter = 0.5 * np.pi * np.arange(4)
        return np.asarray(3.0 + 2.0 * np.sin(np.pi * at + phases + quarter))

    warm = RodBatch(kinds[:1], TIME_STEP)
    warm.step(np.full(4, 3.0))
    total = used = 0.0
    with ThreadPoolExecutor(count) as pool:
        for first in range(0, STEPS, BLOCK):
            given = tensions(first)
            begin, busy = time.perf_counter(), time.process_time()
            batch.step(given, steps=BLOCK, run=pool.map)
            total += time.perf_counter() - begin
            used += time.process_time() - busy
    equal = True
    for index in np.linspace(0, rods - 1, min(CHECKED, rods)).astype(int):
        rod = StrainRod(kinds[index % len(kinds)], TIME_STEP)
        state = rod.rest()
        for first in range(0, STEPS, BLOCK):
            for given in tensions(first)[:, index]:
                state = rod.step(state, rod.loads(given))
        equal &= np.array_equal(state.strain, batch.strain[index]) and np.array_equal(state.rate, batch.rate[index])
    return BatchRow(
        rods, count, total, 1e6 * used / (rods * STEPS), used / count * GOAL_RODS / rods,
        int(batch.counts[:, 2].sum()), bool(equal),
    )  # fmt: skip
