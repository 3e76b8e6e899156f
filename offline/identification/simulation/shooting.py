"""The shooting rod through a recording, one set of parameters at a time."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.rod.rod import Rod
from tendond.model.rod.tip_body import ball_inertia
from tendond.model.rod.trajectory import simulate_trajectory
from tendond.offline.identification.configured import rod_parameters
from tendond.offline.identification.recordings.recording import Recording
from tendond.offline.identification.simulation.motion import SimulationError, TipMotion, shown

Array = NDArray[np.float64]

ALPHA = -0.45
"""Alpha of BDF-alpha: near the trapezoidal rule, since numerical damping would be subtracted from the rod's."""


def shooting_motion(
    recording: Recording, values: Mapping[str, float], start: Array, ends: Array, step: float
) -> TipMotion:
    """Simulate the motion of one rod.

    A jump of the ends within an implicit step counts as one in its middle: so steps end where the ends are given.

    Args:
        recording: the recording. values: of all parameters, by name.
        start: displacements in which it rests before [m], shape (n,).
        ends: displacements of the tendons' ends in the middle of each `step` [s] of the recording [m], shape (k, n).

    Raises:
        SimulationError: no solution; with the time.
    """
    try:
        rod = Rod(rod_parameters(recording.config, values), time_step=step, alpha=ALPHA)
        rod.load_tip(recording.weight, ball_inertia(recording.weight))
    except ParameterError as error:
        raise SimulationError(f"{recording.path}: {error}") from error
    loads = np.tile(rod.loads(start), (len(ends), 1))
    loads[:, : ends.shape[1]] = ends
    try:
        rest = rod.solve_static(displacements=start)
    except ConvergenceError as error:
        raise SimulationError(f"{recording.path}: the rod has no rest to start from: {error}") from error
    found = simulate_trajectory(rod, rest, loads)
    if found.solved < len(loads):
        at = step * (found.solved + 0.5)
        raise SimulationError(f"{recording.path}: the rod has no solution at {at:.2f} s with {shown(values)}")
    return TipMotion(step, -0.5 * step, np.vstack([rod.tip(rest).position, found.tips]), found.tensions)
