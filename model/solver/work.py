"""Scratch memory of a rod: one array, which the kernels open as many; a call from Python carries one argument."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined
from tendond.model.solver.lanes import STATE
from tendond.model.solver.march import Shots
from tendond.model.solver.predictor import PAST
from tendond.model.solver.problem import RodData

LANES = 8
"""Rods that march together for a Jacobian."""

MOMENT_ARM = 0.1
"""Arm that makes n(0) and m(0) comparable, of the rod's length; about that of the tip's load on a bent rod."""


class Work(NamedTuple):
    """Scratch arrays. m = 6 + n; `raw` is the result of a shot: residual 6, tendon lengths n."""

    scale: Any  # (m,): of each unknown, the rod's force scale [N], or that at `MOMENT_ARM` [N m]
    trial: Any  # (m,)
    raw: Any  # (m,)
    raw_trial: Any  # (m,)
    step: Any  # (m,)
    last: Any  # (m,): a continuation's last solution
    slope: Any  # (m,): its change over the whole continuation
    loads: Any  # (n + 15,): a continuation's current loads
    matrix: Any  # (m, m)
    differences: Any  # (PAST, m): of past solutions
    tip: Any  # (24, m): derivatives of the last node's state by the unknowns
    pull: Any  # (width,): tensions of a single shot, and zeros
    shots: Shots  # of `LANES` rods


@inlined
def _take(memory: Any, at: int, rows: int, columns: int) -> Any:
    return memory[at : at + rows * columns].reshape((rows, columns))


@inlined
def open_work(memory: Any, rod: RodData) -> Work:
    """The arrays in `memory`."""
    n, width = rod.tendons, len(rod.x)
    m = 6 + n
    at = 7 * m
    loads = memory[at : at + n + 15]
    at += n + 15
    matrix = _take(memory, at, m, m)
    at += m * m
    differences = _take(memory, at, PAST, m)
    at += PAST * m
    tip = _take(memory, at, STATE, m)
    at += STATE * m
    pull = memory[at : at + width]
    at += width
    base = memory[at : at + 6 * LANES]
    at += 6 * LANES
    tension = memory[at : at + width * LANES]
    at += width * LANES
    length = memory[at : at + width * LANES]
    at += width * LANES
    residual = memory[at : at + 6 * LANES]
    at += 6 * LANES
    node = memory[at : at + STATE * LANES]
    at += STATE * LANES
    return Work(
        memory[:m],
        memory[m : 2 * m],
        memory[2 * m : 3 * m],
        memory[3 * m : 4 * m],
        memory[4 * m : 5 * m],
        memory[5 * m : 6 * m],
        memory[6 * m : 7 * m],
        loads,
        matrix,
        differences,
        tip,
        pull,
        Shots(base, tension, node, length, residual, memory[at:]),
    )


def new_work(rod: RodData, force: float) -> NDArray[np.float64]:
    """Memory for a rod with a force scale [N]."""
    n, width = rod.tendons, len(rod.x)
    m = 6 + n
    solver = 7 * m + n + 15 + m * m + PAST * m + STATE * m + width
    marches = (12 + 2 * width + STATE) * LANES + (2 + len(rod.weights)) * STATE * LANES
    memory = np.zeros(solver + marches)
    memory[:m] = force
    memory[3:6] = MOMENT_ARM * rod.length * force
    return memory
