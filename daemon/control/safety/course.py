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
        self._first = horizon.count - LATER

    def follow(self, state: GeneralState, tensions: Array, force: Array) -> list[StrainState]:
        """Return the states at the samples, under tensions [N], shape (m,), and a force on the tip [N], shape (3,).

        Raises:
            ConvergenceError: a step has no finite solution, or the tensions have no rest.
        """
        self._rod.use(state)
        loads, rod = self._rod.loads(tensions, force, state.body), self._rod.strain_rod
        now, found = state.strain, []
        for _ in range(self._first):
            now = rod.step(now, loads)
            found.append(now)
        return found + [rod.solve_static(loads, now)] * LATER
