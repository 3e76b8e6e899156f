"""The state of a rod between two steps: everything that its next step depends on, to be copied and restored exactly."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.solver.predictor import RING
from tendond.model.solver.problem import HISTORY, StateData

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
        residual: norm of force and moment missing at the tip [N], the moment at the arm `solver.shooting.ARM`.
        marches: marches along the rod that the last solution took.
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
        """Return an independent copy."""
        return self._with_rings(self.levels.copy(), self.histories.copy(), self.geometries.copy())

    def successor(self) -> "RodState":
        """Copy the state to be advanced by one step: entries of the rings that this step overwrites are not copied."""
        levels, histories = np.empty_like(self.levels), np.empty_like(self.histories)
        geometries = np.empty_like(self.geometries)
        now, last = self.count % 3, (self.count - 1) % 3
        levels[now], levels[last] = self.levels[now], self.levels[last]
        histories[self.count % 2] = self.histories[self.count % 2]
        geometries[self.count % 2] = self.geometries[self.count % 2]
        return self._with_rings(levels, histories, geometries)

    def _with_rings(self, levels: Array, histories: Array, geometries: Array) -> "RodState":
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

    def rest(self, c0: float) -> None:
        """Fill the rings with the state of step 0 as one that has always been: at rest.

        Args:
            c0: of BDF-alpha [1/s].
        """
        self.levels[1:] = self.levels[0]
        self.histories[:] = -c0 * self.levels[0]
        self.geometries[1] = self.geometries[0]
        self.unknowns[1:] = self.unknowns[0]
        self.jacobian[:] = 0.0

    def data(self) -> StateData:
        """The state as the kernels take it: the same arrays, not copies."""
        return StateData(
            self.count,
            self.displacement_driven,
            self.levels,
            self.histories,
            self.geometries,
            self.unknowns,
            self.loads,
            self.lengths,
            self.jacobian,
        )

    @property
    def tensions(self) -> Array:
        """Tensions of the tendons [N], shape (n,)."""
        return self.unknowns[self.count % RING, 6:].copy()

    @property
    def shape(self) -> Array:
        """Positions of the nodes from base to tip, world frame [m], shape (nodes, 3)."""
        return self.geometries[self.count % 2, :, :3].copy()

    @property
    def rotations(self) -> Array:
        """Orientations of the nodes, body to world, shape (nodes, 3, 3)."""
        return self.geometries[self.count % 2, :, 3:].reshape(-1, 3, 3).copy()


def blank_state(tendons: int, stages: int, nodes: int, displacement_driven: bool) -> RodState:
    """A state of zeros, of step 0.

    Args:
        tendons: their number.
        stages, nodes: of the space scheme, along the rod.
        displacement_driven: see `RodState`.
    """
    m = 6 + tendons
    return RodState(
        count=0,
        time=0.0,
        displacement_driven=displacement_driven,
        levels=np.zeros((3, stages, HISTORY)),
        histories=np.zeros((2, stages, HISTORY)),
        geometries=np.zeros((2, nodes, 12)),
        unknowns=np.zeros((RING, m)),
        loads=np.zeros(tendons + 15),
        lengths=np.zeros(tendons),
        jacobian=np.zeros((m, m)),
        residual=0.0,
        marches=0,
    )
