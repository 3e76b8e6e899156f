"""Benchmark of many rods at once: steps per second over threads, and whether they are those of rods one by one."""

import os
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.strain import Body, Robot, Section, StrainRod, Tendon
from tendond.model.strain.batch import RodBatch
from tendond.model.strain.describe.base import Base
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

Array = NDArray[np.float64]

TIME_STEP = 0.01
STEPS = 100
BLOCK = 10
CHECKED = 6
FRICTION = 0.1
SHAKEN = Base(velocity=np.array([0.0, 0.3, 0.0]), spin=np.array([0.0, 0.0, 1.0]), spin_rate=np.array([0.5, 0.0, 0.0]))
GOAL_RODS, GOAL_SECONDS = 100_000, 90.0


@dataclass(frozen=True)
class BatchRow:
    """Figures of a run.

    Attributes:
        rods, threads: of the run. seconds: for 1 s of motion of all rods.
        step_us: processor time of a step of a rod [us]: what it takes on a core of its own.
        goal_seconds: for 10^5 rods on as many cores as threads, by that; the goal is 90 s on two.
        friction_ratio: time of a step of a rod with friction, in a batch in which every other one has it, to step_us.
        base_ratio: the same of a rod whose base moves.
        minima: steps that ended in a minimum. equal: whether rods stepped one by one end in the same bits.
    """

    rods: int
    threads: int
    seconds: float
    step_us: float
    goal_seconds: float
    friction_ratio: float
    base_ratio: float
    minima: int
    equal: bool


def robot(stiffness: float = 1.0, friction: float = 0.0) -> Robot:
    """Return the paper's robot with a factor on Young's modulus, elastic tendons and a marker body."""
    modulus = YOUNGS_MODULUS * stiffness
    section = Section.round(LENGTH, RADIUS, modulus, DENSITY, bending_damping=BENDING_DAMPING, drag=DRAG)
    tendons = tuple(Tendon(LENGTH, one, 2e4, friction) for one in TENDON_POSITIONS)
    return Robot((section,), tendons, (Body(LENGTH, 0.005),), GRAVITY)


@dataclass(frozen=True)
class _Rods:
    """Rods that are stepped together, each with its own smooth tensions, and a base that every other one has."""

    robots: list[Robot]
    base: Base | None = None

    def bases(self, begin: int) -> list[Base | None]:
        """Bases at the beginning of a step."""
        moved = None if self.base is None else self.base.after(begin * TIME_STEP)
        return [moved if i % 2 else None for i in range(len(self.robots))]

    def tensions(self, begin: int) -> Array:
        """Tensions of `BLOCK` steps [N], shape (BLOCK, N, 4)."""
        phases = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, (len(self.robots), 1))
        at = TIME_STEP * np.arange(begin, begin + BLOCK)[:, None, None]
        return np.asarray(3.0 + 2.0 * np.sin(np.pi * at + phases + 0.5 * np.pi * np.arange(4)))

    def run(self, count: int) -> tuple[float, float, RodBatch]:
        """Step them for 1 s by some threads; return time and processor time [s], and the batch at the end."""
        batch = RodBatch(self.robots, TIME_STEP, count)
        total = used = 0.0
        with ThreadPoolExecutor(count) as pool:
            for begin in range(0, STEPS, BLOCK):
                tension, base = self.tensions(begin), self.bases(begin)
                started, busy = time.perf_counter(), time.process_time()
                batch.step(tension=tension, base=base, steps=BLOCK, run=pool.map)
                total += time.perf_counter() - started
                used += time.process_time() - busy
        return total, used, batch

    def ends_alike(self, batch: RodBatch) -> bool:
        """Step some of the rods one by one; return whether they end in the same bits."""
        equal = True
        for index in np.linspace(0, len(self.robots) - 1, min(CHECKED, len(self.robots))).astype(int):
            rod = StrainRod(self.robots[index], TIME_STEP)
            state = rod.rest()
            for begin in range(0, STEPS, BLOCK):
                base = self.bases(begin)[index]
                for k, given in enumerate(self.tensions(begin)[:, index]):
                    moved = None if base is None else base.after(k * TIME_STEP)
                    state = rod.step(state, rod.loads(given), moved)
            equal &= np.array_equal(state.strain, batch.strain[index]) and np.array_equal(state.rate, batch.rate[index])
        return bool(equal)


def bench_batch(rods: int, threads: int | None = None) -> BatchRow:
    """Time 1 s of motion of rods of 20 stiffnesses; then with friction, or with a moving base, of every other one."""
    count = threads or len(os.sched_getaffinity(0))
    kinds, rubbing = ([robot(0.9 + 0.01 * k, mu) for k in range(20)] for mu in (0.0, FRICTION))
    plain = [kinds[i % 20] for i in range(rods)]
    cases = (
        _Rods(plain), _Rods([rubbing[i % 20] if i % 2 else plain[i] for i in range(rods)]), _Rods(plain, SHAKEN),
    )  # fmt: skip
    for case in cases:
        _Rods(case.robots[:2], case.base).run(1)
    (total, used, batch), mixed, moved = (case.run(count) for case in cases)
    others = rods // 2
    friction, base = (1.0 + (one - used) / used * rods / max(1, others) for one in (mixed[1], moved[1]))
    equal = all(case.ends_alike(one) for case, one in zip(cases, (batch, mixed[2], moved[2]), strict=True))
    return BatchRow(
        rods, count, total, 1e6 * used / (rods * STEPS), used / count * GOAL_RODS / rods, friction, base,
        int(batch.counts[:, 2].sum()), equal,
    )  # fmt: skip
