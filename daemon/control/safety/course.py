"""The model's own motion under held tensions, where the linear one of `horizon` is not exact enough: in large motions.

The model is stepped from sample to sample through the first period of its slowest mode; the later samples have the rest
that it settles to. The implicit steps are stable and keep energy at any length, so amplitudes are right where twelve
steps a period make that two percent long.
"""

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.safety.horizon import LATER, Horizon
from tendond.model.rods.general import GeneralRod, GeneralState
from tendond.model.strain.state import StrainState

Array = NDArray[np.float64]


class Course:
    """Motions at the samples of a horizon. Not for use by two threads at once.

    Args:
        rod: the model. horizon: times of the samples.
    """

    def __init__(self, rod: GeneralRod, horizon: Horizon) -> None:
        self._rod = GeneralRod(rod.robot, horizon.spacing, rod.compliance)
        self._first, self._lag = horizon.count - LATER, horizon.lag_factor

    def follow(self, state: GeneralState, before: Array, after: Array, force: Array) -> list[StrainState]:
        """Return the states at the samples of the first period, and the rest, which the later ones have.

        Args:
            state: now. before, after: tensions now, and those that the actuators go to, with their lag [N], shape (m,).
            force: on the tip [N], shape (3,).

        Raises:
            ConvergenceError: a step has no finite solution, or the tensions have no rest.
        """
        self._rod.use(state)
        rod, now, found = self._rod.strain_rod, state.strain, []
        for index in range(self._first):
            tensions = after + self._lag ** (index + 0.5) * (before - after)  # in the middle of the step
            now = rod.step(now, self._rod.loads(tensions, force, state.body))
            found.append(now)
        return [*found, rod.solve_static(self._rod.loads(after, force, state.body), now)]
