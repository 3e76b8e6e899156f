"""Rests of a rod whose tendons rub: from the unloaded shape, or on from another rest, in parts where one is too far."""

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import Bound
from tendond.model.strain.friction.rest import settle
from tendond.model.strain.layout import Layout
from tendond.model.strain.minima.minimise import minimise
from tendond.model.strain.stepping.scratch import Loads, Scratch
from tendond.model.strain.tendons import find_paths

Array = NDArray[np.float64]

HALVINGS = 6
"""Halvings of the change of the tendons' loads."""


def pulls_of(work: Scratch) -> tuple[Array | None, float]:
    """Return tensions along the tendons after a step [N], shape (F, 1 + Q), and what friction took away in it [J]."""
    grip = work.grip
    return (grip.tension.copy(), float(grip.lost[0])) if len(grip.tendon) > 0 else (None, 0.0)


class FrictionStatics:
    """Equilibria of one robot with friction, each from a state before.

    Args:
        layout: of the robot. work: scratch arrays. tolerance: of the strains [rad], in the measure of energy.
    """

    def __init__(self, layout: Layout, work: Scratch, tolerance: float) -> None:
        self._layout, self._work, self._tolerance = layout, work, tolerance
        self._settle, self._minimise = Bound(settle), Bound(minimise)

    def solve(self, loads: Loads, strain: Array, pulls: Array, fresh: bool) -> tuple[int, Array, Array, float]:
        """Return Newton's iterations (-1: none found), strains, tensions along the tendons [N], friction's work [J].

        Args:
            loads: on the robot. strain: before, shape (n,). pulls: before, shape (F, 1 + Q).
            fresh: whether the state before is the unloaded shape, which is no guess of the one after it.
        """
        return self._solve(loads, strain, pulls, fresh, 0)

    def _solve(
        self, loads: Loads, strain: Array, pulls: Array, fresh: bool, depth: int
    ) -> tuple[int, Array, Array, float]:
        layout, work = self._layout, self._work
        rubbing = work.grip.tendon
        tension, driven = loads.tension.copy(), loads.driven.copy()
        tension[rubbing], driven[rubbing] = 0.0, False
        other = loads._replace(tension=tension, driven=driven)
        for minimum in (True, False) if fresh else (False, True):
            q = strain.copy()
            if minimum:
                self._minimise.call(layout, loads, q, 0.0, self._tolerance, work)
            work.q0[:], work.grip.start[:] = strain, pulls
            count = int(self._settle.call(layout, loads, other, q, self._tolerance, work))
            if count > 0 and np.all(np.isfinite(q)):
                return count, q, work.grip.tension.copy(), float(work.grip.lost[0])
        if depth == HALVINGS:
            return -1, strain, pulls, 0.0
        middle = self._middle(loads, strain, pulls)
        first = self._solve(middle, strain, pulls, fresh, depth + 1)
        if first[0] < 0:
            return first
        last = self._solve(loads, first[1], first[2], False, depth + 1)
        return (last[0] if last[0] < 0 else first[0] + last[0]), last[1], last[2], first[3] + last[3]

    def _middle(self, loads: Loads, strain: Array, pulls: Array) -> Loads:
        """Loads with the tendons that rub half way from where they were."""
        grip, paths = self._work.grip, self._work.paths_before
        find_paths(self._layout, strain, paths)
        tension = loads.tension.copy()
        for row, i in enumerate(grip.tendon):
            was = pulls[row, 0]
            if loads.driven[i]:
                was = paths.displacement[i] + self._layout.compliance[:, i] @ pulls[row, 1:]
            tension[i] = 0.5 * (was + tension[i])
        return loads._replace(tension=tension)
