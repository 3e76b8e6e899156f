"""Simulate a rod through a whole sequence of loads in one compiled call: for fits, which take thousands of steps."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.model.numerics.compile import Bound, kernel
from tendond.model.rod.rod import Rod
from tendond.model.rod.state import RodState
from tendond.model.solver.predictor import RING
from tendond.model.solver.problem import Bdf, RodData, StateData
from tendond.model.solver.shooting import SOLVED
from tendond.model.solver.timestep import advance

Array = NDArray[np.float64]


@kernel
def advance_all(rod: RodData, memory: Any, bdf: Bdf, state: StateData, loads: Any, tips: Any, tensions: Any) -> int:
    """Advance `state` by a step for each row of `loads`, shape (steps, n + 15), and return the number of steps solved.

    The arrays of `state` are overwritten; `tips`, shape (steps, 3), and `tensions`, shape (steps, n), are written.
    """
    n = tensions.shape[1]
    for k in range(loads.shape[0]):
        now = StateData(
            state.step + k, state.displacement_driven, state.levels, state.histories, state.geometries, state.unknowns,
            state.loads, state.lengths, state.jacobian,
        )  # fmt: skip
        status, _, _ = advance(rod, memory, bdf, now, loads[k])
        if status != SOLVED:
            return int(k)
        count = now.step + 1
        last = state.geometries.shape[1] - 1
        for j in range(3):
            tips[k, j] = state.geometries[count % 2, last, j]
        for i in range(n):
            tensions[k, i] = state.unknowns[count % RING, 6 + i]
    return int(loads.shape[0])


@dataclass(frozen=True)
class TipTrajectory:
    """Tip and tensions of a rod through a sequence of loads.

    Attributes:
        solved: number of steps; rows after the last one solved are NaN.
        tips: positions after each step, world frame [m], shape (steps, 3).
        tensions: tensions of the tendons then [N], shape (steps, n).
    """

    solved: int
    tips: Array
    tensions: Array


_bound: dict[int, Bound] = {}
"""The kernel, by the width of the rod's tendons."""


def simulate_trajectory(rod: Rod, start: RodState, loads: Array) -> TipTrajectory:
    """Simulate `rod` from `start` through a sequence of loads, one time step each; `start` is not changed.

    The GIL is released meanwhile: rods of their own run in threads of their own.

    Args:
        rod: driven as `start` is.
        start: start of this rod.
        loads: loads of each step, as `Rod.loads` gives them, shape (steps, n + 15).

    Raises:
        ParameterError: a state of another rod, loads of the wrong shape or not finite.
    """
    n = rod.parameters.tendon_count
    if loads.ndim != 2 or loads.shape[1] != n + 15 or not np.all(np.isfinite(loads)):
        raise ParameterError(f"loads have shape {loads.shape}, must be finite and (steps, {n + 15})")
    state = start.copy()
    rod._check(state)
    tips, tensions = np.full((len(loads), 3), np.nan), np.full((len(loads), n), np.nan)
    run = _bound.setdefault(len(rod._data.x), Bound(advance_all))
    solved = run.call(rod._data, rod._work, rod._bdf, state.data(), np.ascontiguousarray(loads), tips, tensions)
    return TipTrajectory(int(solved), tips, tensions)
