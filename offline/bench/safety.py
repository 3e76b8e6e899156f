"""Cost of the safety filter, beside a step of the model of the same robot."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.safety.configured import configured_barrier
from tendond.model.rods.general import GeneralRod
from tendond.model.rods.selection import model_rod
from tendond.model.strain.derivatives.linearise import Linearisation
from tendond.schemas.config.rig import check_config

Array = NDArray[np.float64]

PULL = 13.0
"""Tension of the paper's robot, bent to 0.17 m [N]: a newton more brings its tip to the obstacle."""

OBSTACLE = {"kind": "sphere", "center": (0.25, 0.0, 0.42), "radius": 0.05}


@dataclass(frozen=True)
class Cost:
    """Time of a computation, in this thread.

    Attributes:
        name: what is computed. median, p99: [us]. steps: median in steps of the model [-].
    """

    name: str
    median: float
    p99: float
    steps: float


def measure_filter(repeats: int) -> list[Cost]:
    """Return the cost of a step, of its linear model, and of the filter where it alters nothing and where it does."""
    config = check_config({"safety": {"margin": 0.003, "obstacle": [OBSTACLE]}}, "bench")
    rod = model_rod(config)
    assert isinstance(rod, GeneralRod)
    barrier, linear = configured_barrier(config, rod, 0.0), Linearisation(rod.strain_rod)
    assert barrier is not None
    tensions = np.array([PULL, 1.0, 1.0, 1.0])
    state = rod.step(rod.solve_static(tensions), tensions)
    loads, zero = rod.loads(tensions), np.zeros(3)

    def filtered(more: float) -> Callable[[], object]:
        wanted = tensions + np.array([more, 0.0, 0.0, 0.0])
        bounds = tensions - 4.0, tensions + 4.0
        return lambda: barrier.filter(state, tensions, zero, zero, wanted, *bounds)

    tasks: dict[str, Callable[[], object]] = {
        "step of the model": lambda: rod.step(state, tensions),
        "its linear model": lambda: linear.step(state.strain, loads),
        "filter, nothing altered": filtered(0.0),
        "filter, command altered": filtered(4.0),
    }
    times = {name: _times(task, repeats) for name, task in tasks.items()}
    step = float(np.median(times["step of the model"]))
    return [
        Cost(name, float(np.median(some)), float(np.quantile(some, 0.99)), float(np.median(some)) / step)
        for name, some in times.items()
    ]


def _times(task: Callable[[], object], repeats: int) -> Array:
    """Return times of calls [us], after one that is not counted."""
    task()
    found = np.empty(repeats)
    for index in range(repeats):
        start = time.thread_time_ns()
        task()
        found[index] = 1e-3 * (time.thread_time_ns() - start)
    return found
