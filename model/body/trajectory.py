"""The trajectory of a robot under tensions that are known beforehand, in one kernel: steps, and points of the body."""

import numpy as np
from numpy.typing import NDArray

from tendond.model.body.points import PointWeights, place_points
from tendond.model.errors import ConvergenceError
from tendond.model.numerics.compile import Bound, lean
from tendond.model.strain.layout import Layout
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.state import StrainState, trend_of
from tendond.model.strain.stepping.advance import advance
from tendond.model.strain.stepping.scratch import Loads, Scratch, mirrored, scratch_for

Array = NDArray[np.float64]


@lean
def _step(
    layout: Layout, loads: Loads, q: Array, w: Array, h: float, tolerance: float, work: Scratch, known: bool,
    weights: PointWeights, points: Array,
) -> None:  # fmt: skip
    """Advance strains and rates by a step, in place, and write the points after it."""
    advance(layout, loads, q, w, h, tolerance, work, known)
    place_points(work.after, weights, points)


@lean
def follow(
    layout: Layout, loads: Loads, tensions: Array, q: Array, w: Array, before: Array, h: float, tolerance: float,
    work: Scratch, other: Scratch, weights: PointWeights, strains: Array, points: Array,
) -> bool:  # fmt: skip
    """Step from q and w, in place, under the tensions of each step; return whether all states are finite.

    Args:
        layout: of the robot. loads: on it; the tensions are overwritten. tensions: of each step [N], shape (k, m).
        q, w: strains and rates, shape (n,). before: rates a step before, shape (n,); overwritten.
        h: [s]. tolerance: see `advance`. work, other: scratch arrays, each the `mirrored` of the other.
        weights: of the points. strains: after each step, shape (k, n). points: then [m], shape (k, p, 3).
    """
    n, rubbing = len(q), len(work.grip.tendon) > 0
    for index in range(len(tensions)):
        for i in range(len(loads.tension)):
            loads.tension[i] = tensions[index, i]
        for a in range(n):
            strains[index, a] = w[a]  # the rates before the step, until its strains are known
        if index % 2 == 0:
            _step(layout, loads, q, w, h, tolerance, work, index > 0, weights, points[index])
        else:
            _step(layout, loads, q, w, h, tolerance, other, True, weights, points[index])
        total = 0.0
        for a in range(n):
            work.trend[a] = 0.5 * (strains[index, a] - before[a])
            before[a] = strains[index, a]
            strains[index, a] = q[a]
            total += abs(q[a]) + abs(w[a])
        if not np.isfinite(total):
            return False
        if rubbing:
            for i in range(len(work.grip.start)):
                for k in range(work.grip.start.shape[1]):
                    work.grip.start[i, k] = work.grip.tension[i, k]
    return True


class Trajectory:
    """Trajectories of a rod, in steps of its own time. Not for use by two threads at once.

    Args:
        rod: the rod, whose base does not move. weights: of the points of its body.
    """

    def __init__(self, rod: StrainRod, weights: PointWeights, tolerance: float) -> None:
        self._rod, self._weights, self._tolerance = rod, weights, tolerance
        self._work = scratch_for(rod.layout)
        self._other = mirrored(self._work)
        self._follow = Bound(follow)

    def follow(self, state: StrainState, loads: Loads, tensions: Array) -> tuple[Array, Array, StrainState]:
        """Return strains, shape (k, n), and points [m], shape (k, p, 3), after each step, and the last state.

        Args:
            state: at the start. loads: on the rod but for its tensions. tensions: of each step [N], shape (k, m).

        Raises:
            ConvergenceError: a state, or tensions, that are not finite.
        """
        rod, work, count = self._rod, self._work, len(tensions)
        strains, points = np.empty((count, rod.modes)), np.empty((count, len(self._weights.places), 3))
        q, w = state.strain.copy(), state.rate.copy()
        before = w.copy() if state.earlier is None else state.earlier[0].copy()
        work.trend[:] = trend_of(state.earlier)
        if len(work.grip.tendon) > 0:
            work.grip.start[:] = 0.0 if state.pulls is None else state.pulls
        loads = loads._replace(tension=np.empty_like(tensions[0]))
        done = self._follow.call(
            rod.layout, loads, tensions, q, w, before, rod.time_step, self._tolerance, work, self._other,
            self._weights, strains, points,
        )  # fmt: skip
        if not (done and np.isfinite(tensions).all()):
            raise ConvergenceError("dynamics: the step from a state, or under loads, that are not finite", 0.0, 0.0, 0)
        pulls = work.grip.start.copy() if len(work.grip.tendon) > 0 else None
        return strains, points, StrainState(q, w, pulls=pulls)
