"""What a rod is at one instant: everything that its next step depends on, to be copied, saved and restored exactly."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.solver.predictor import RING

Array = NDArray[np.float64]


@dataclass
class RodState:
    """Everything that the next step of a rod depends on. Arrays with a leading ring axis are indexed by `count`.

    Attributes:
        count: steps since the static solution that it started from.
        time: [s] since then.
        displacement_driven: tendons are given by commanded displacement [m] rather than tension [N].
        levels: strain e = v - v*, u, q, w, v_s, u_s at every stage, shape (3, stages, 18).
        histories: y_h of the same, shape (2, stages, 18).
        geometries: p [m] and R at every node, shape (2, nodes, 12).
        unknowns: n(0) [N], m(0) [N m], tensions [N], shape (8, 6 + n).
        loads: tendon commands, tip force, tip moment, distributed force and moment, and push, of the last
            step, shape (n + 15,).
        lengths: tendon path lengths [m], shape (n,).
        jacobian: carried by the solver, shape (6 + n, 6 + n).
        residual: norm of force and moment missing at the tip [N, N m].
        marches: along the rod that the last solution took.
    """

    count: int
    time: float
    displacement_driven: bool
    levels: Array
    histories: Array
    geometries: Array
    unknowns: Array
    loads: Array
    lengths: Array
    jacobian: Array
    residual: float
    marches: int

    def copy(self) -> "RodState":
        """An independent copy."""
        return RodState(
            self.count,
            self.time,
            self.displacement_driven,
            self.levels.copy(),
            self.histories.copy(),
            self.geometries.copy(),
            self.unknowns.copy(),
            self.loads.copy(),
            self.lengths.copy(),
            self.jacobian.copy(),
            self.residual,
            self.marches,
        )

    def successor(self) -> "RodState":
        """A copy to be advanced by one step: what that step overwrites in the rings is not copied."""
        levels, histories = np.empty_like(self.levels), np.empty_like(self.histories)
        geometries = np.empty_like(self.geometries)
        now, last = self.count % 3, (self.count - 1) % 3
        levels[now], levels[last] = self.levels[now], self.levels[last]
        histories[self.count % 2] = self.histories[self.count % 2]
        geometries[self.count % 2] = self.geometries[self.count % 2]
        return RodState(
            self.count,
            self.time,
            self.displacement_driven,
            levels,
            histories,
            geometries,
            self.unknowns.copy(),
            self.loads.copy(),
            self.lengths.copy(),
            self.jacobian.copy(),
            self.residual,
            self.marches,
        )

    @property
    def tensions(self) -> Array:
        """Of the tendons [N], shape (n,)."""
        return self.unknowns[self.count % RING, 6:].copy()

    @property
    def shape(self) -> Array:
        """Positions of the nodes from base to tip, world frame [m], shape (nodes, 3)."""
        return self.geometries[self.count % 2, :, :3].copy()

    @property
    def rotations(self) -> Array:
        """Orientations of the nodes, body to world, shape (nodes, 3, 3)."""
        return self.geometries[self.count % 2, :, 3:].reshape(-1, 3, 3).copy()
