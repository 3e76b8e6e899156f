"""Wrenches that turn with the cross-section they act on: equilibria, and loads of a step.

A follower force is the gradient of no energy, so its equilibria are no minima: Newton's method on the balance, with the
exact tangent, follows the rest as the wrench grows from nothing.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.strain.derivatives.acceleration import tangent_stiffness
from tendond.model.strain.derivatives.room import Room, room_for
from tendond.model.strain.kinematics import empty_shape, find_shape
from tendond.model.strain.loads import Wrench
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.state import StrainState
from tendond.model.strain.stepping.scratch import Loads, Scratch, scratch_for

Array = NDArray[np.float64]

TOLERANCE = 1e-11
"""Root of the correction's energy at which Newton's method ends, as a part of that of 1 rad in the softest section."""

ITERATIONS = 25
"""Largest number of Newton steps for one part of the wrench; the part is halved then. Chosen; `pytest
tests/unit/strain/test_loads.py -k follower` passes with it."""

HALVINGS = 12
"""Number of steps in which the wrench grows, below 1 / 16 of it, before a fold is reported: a
part of 1.5e-5 of the whole. Chosen."""


class Followers:
    """Wrenches on a rod that turn with it.

    Args:
        rod: the general rod.
        wrenches: arc length [m], force [N], moment [N m] each, in the frame of the cross-section there.

    Raises:
        ParameterError: a place without a node, or not three finite numbers.
    """

    def __init__(self, rod: StrainRod, wrenches: Sequence[Wrench]) -> None:
        self.rod = rod
        self._at = [rod.node(at) for at, _, _ in wrenches]
        self._given = [np.asarray((force, moment), dtype=np.float64) for _, force, moment in wrenches]
        if not all(one.shape == (2, 3) and np.all(np.isfinite(one)) for one in self._given):
            raise ParameterError("loads: force and moment of a follower must be three finite numbers each")
        self._shape = empty_shape(rod.layout)

    def loads(self, state: StrainState, loads: Loads, ahead: float = 0.5) -> Loads:
        """Return the loads of a step from `state`, the wrenches as they stand `ahead` of a step later.

        With the half of it, their direction is right to second order in the time step.
        """
        find_shape(self.rod.layout, state.strain + ahead * self.rod.time_step * state.rate, self._shape)
        force, moment = loads.force.copy(), loads.moment.copy()
        for (node, point), (pushed, turned) in zip(self._at, self._turned(1.0), strict=True):
            force[point] += pushed
            moment[node] += turned
        return loads._replace(force=force, moment=moment)

    def solve_static(self, loads: Loads, start: StrainState | None = None) -> StrainState:
        """Return the equilibrium that grows from that without the wrenches; it need not be stable.

        Raises:
            ConvergenceError: the path ends before the whole wrench, as at a fold.
        """
        rod = self.rod
        q = rod.solve_static(loads, start).strain
        work, room = scratch_for(rod.layout), room_for(rod.layout)
        part, step, count = 0.0, 1.0 / 16.0, 0
        while part < 1.0:
            goal = min(1.0, part + step)
            trial = q.copy()
            for _ in range(ITERATIONS):
                residual, tangent = self._balance(trial, goal, loads, work, room)
                change = np.linalg.solve(tangent, residual)
                trial -= change
                count += 1
                size = float(change @ rod.layout.stiffness @ change)
                if not np.isfinite(size) or size <= TOLERANCE**2 * work.unit[0]:
                    break
            else:
                size = np.inf
            if np.isfinite(size):
                q, part, step = trial, goal, min(2.0 * step, 0.25)
            else:
                step *= 0.5
                if step < 2.0**-HALVINGS / 16.0:
                    raise ConvergenceError(
                        f"statics: the rest under a follower ends at {part:.3g} of it, as at a fold", 0.0, 0.0, count
                    )
        return StrainState(q, np.zeros(rod.modes), count)

    def _turned(self, part: float) -> list[tuple[Array, Array]]:
        """Force and moment of each wrench in the world frame, at the shape last found."""
        turns = [self._shape.rotation[node].reshape(3, 3) for node, _ in self._at]
        return [(part * turn @ one[0], part * turn @ one[1]) for turn, one in zip(turns, self._given, strict=True)]

    def _balance(self, q: Array, part: float, loads: Loads, work: Scratch, room: Room) -> tuple[Array, Array]:
        """Residual and tangent of the statics at q, shape (n,) and (n, n)."""
        layout, shape = self.rod.layout, self._shape
        find_shape(layout, q, shape)
        jacobian, turning = shape.jacobian[:, :, : len(q)], shape.twist[:, :3, : len(q)]
        turned = self._turned(part)
        force, moment = loads.force.copy(), loads.moment.copy()
        for (node, point), (pushed, spun) in zip(self._at, turned, strict=True):
            force[point] += pushed
            moment[node] += spun
        tangent = np.zeros((len(q), len(q)))
        tangent_stiffness(layout, loads._replace(force=force, moment=moment), q, work, room, tangent)
        weight = force + layout.mass[:, None] * layout.gravity
        residual = layout.stiffness @ q - np.einsum("pin,pi->n", jacobian, weight)
        residual -= np.einsum("kin,ki->n", turning, moment)
        if len(layout.straight):
            residual -= work.taut @ work.paths_after.gradient
        for (node, point), (pushed, spun) in zip(self._at, turned, strict=True):
            turns = turning[node]
            tangent -= jacobian[point].T @ np.cross(turns, pushed, axisa=0, axisc=0)
            tangent -= turns.T @ np.cross(turns, spun, axisa=0, axisc=0)
        return residual, tangent
