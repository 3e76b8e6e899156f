"""The model's own motion under held tensions, where the linear one of `horizon` is not exact enough: in large motions.

The model is stepped from sample to sample through the first period of its slowest mode; the later samples have the rest
that it settles to. The implicit steps are stable and keep energy at any length, so amplitudes are right where twelve
steps a period make that two percent long.
"""

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.safety.body import Body
from tendond.daemon.control.safety.horizon import LATER, Horizon
from tendond.model.body.trajectory import Trajectory
from tendond.model.rods.general import GeneralRod, GeneralState

Array = NDArray[np.float64]

TOLERANCE = 1e-6
"""Tolerance of the steps' strains [rad], in the measure of energy: micrometres of a meter, a tenth of `ENOUGH`."""


class Course:
    """Motions at the samples of a horizon. Not for use by two threads at once.

    Args:
        rod: the model. body: its places. horizon: times of the samples.
    """

    def __init__(self, rod: GeneralRod, body: Body, horizon: Horizon) -> None:
        self._rod, self._body = GeneralRod(rod.robot, horizon.spacing, rod.compliance), body
        self._trajectory = Trajectory(self._rod.strain_rod, body.weights, TOLERANCE)
        count = horizon.count - LATER
        self._left = horizon.lag_factor ** (np.arange(count) + 0.5)  # in the middle of each step

    def follow(self, state: GeneralState, before: Array, after: Array, force: Array) -> tuple[Array, Array]:
        """Return strains, shape (k, n), and points [m], shape (k, p, 3), at the samples.

        The first ones are steps of the model, the later ones the rest that it settles to.

        Args:
            state: now. before, after: tensions now, and those that the actuators go to, with their lag [N], shape (m,).
            force: on the tip [N], shape (3,).

        Raises:
            ConvergenceError: a step has no finite solution, or the tensions have no rest.
        """
        self._rod.use(state)
        loads = self._rod.loads(after, force, state.body)
        tensions = after + self._left[:, None] * (before - after)
        strains, points, last = self._trajectory.follow(state.strain, loads, tensions)
        rest = self._rod.strain_rod.solve_static(loads, last)
        later = self._body.shape(rest).points
        return np.concatenate((strains, [rest.strain] * LATER)), np.concatenate((points, [later] * LATER))
