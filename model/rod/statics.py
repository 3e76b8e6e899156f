"""Equilibria at rest, by continuation in the loads."""

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.numerics.compile import Bound
from tendond.model.rod.discrete_rod import DiscreteRod
from tendond.model.rod.loads import ZERO, tendon_commands
from tendond.model.rod.state import RodState, blank_state
from tendond.model.solver.predictor import RING
from tendond.model.solver.shooting import ARM, SOLVED
from tendond.model.solver.timestep import relax

Array = NDArray[np.float64]

TENSION_PER_PART = 10.0
"""Tension that a solve tries to take at once on the paper's robot [N]: it bends any rod by 0.67 rad. Only a start: the
continuation halves and doubles it."""

FORCE_PER_PART = 1.0
"""Load that a solve tries to take at once, likewise [N]: on the tip it bends a straight rod by half its length."""

STRING_PART = 0.01
"""Part of the tension k d that is left of a displacement d when the rod has yielded: only a start, too."""


class StaticRod(DiscreteRod):
    """A rod of which the equilibria can be found; arguments as those of `Rod`."""

    _relax = cached_property(lambda self: Bound(relax))

    def solve_static(
        self,
        tensions: ArrayLike | None = None,
        *,
        displacements: ArrayLike | None = None,
        tip_force: ArrayLike = ZERO,
        tip_moment: ArrayLike = ZERO,
        distributed_force: ArrayLike = ZERO,
        distributed_moment: ArrayLike = ZERO,
        push: ArrayLike = ZERO,
        start: RodState | None = None,
    ) -> RodState:
        """Find the equilibrium at rest, by continuation in the loads from `start`, or from the straight, unloaded rod.

        Args:
            tensions: [N], shape (n,); none of them negative. Give these or `displacements`.
            displacements: commanded displacement of each tendon's end [m], shape (n,): the tendon is an elastic string,
                T = max(0, k (commanded - d)).
            tip_force, tip_moment: world frame [N], [N m].
            distributed_force, distributed_moment: beside gravity, world frame [N/m], [N].
            push: force spread as `spread_push` says, world frame [N].
            start: a neighbouring equilibrium of this rod, with the same drive.

        Raises:
            ParameterError: loads of the wrong shape, not finite, negative tensions; a `start` of another rod or drive.
            ConvergenceError: no equilibrium was found.
        """
        actuation, displacement_driven = tendon_commands(self.parameters.tendon_count, tensions, displacements)
        loads = self.loads(actuation, tip_force, tip_moment, distributed_force, distributed_moment, push)
        if start is not None:
            self._check(start)
            if start.displacement_driven is not displacement_driven:
                raise ParameterError(
                    "start is driven differently: give an equilibrium under tensions or displacements, as asked for"
                )
        n, marches = self.parameters.tendon_count, 0
        state = blank_state(n, self._stages, self.nodes, displacement_driven)
        # Straight to the loads first; where that leads into a fold, the tendons alone, or all but the tendons, before.
        tendons_first, tendons_last = loads.copy(), loads.copy()
        tendons_first[n : n + 6], tendons_last[:n] = 0.0, 0.0
        paths = [[loads]] if start is not None else [[loads], [tendons_first, loads], [tendons_last, loads]]
        for path in paths:
            state.unknowns[0] = 0.0 if start is None else start.unknowns[start.count % RING]
            state.loads[:] = 0.0 if start is None else start.loads
            state.jacobian[:] = 0.0
            for target in path:
                first = 1.0 / self._parts(target - state.loads, displacement_driven)
                status, error, more = self._relax.call(
                    self._data, self._work, self._no_history, state.data(), target, first
                )
                marches += more
                if status != SOLVED:
                    break
                state.loads[:] = target
            if status == SOLVED:
                break
        if status != SOLVED:
            raise ConvergenceError("statics did not converge", 0.0, error, marches)
        state.rest(self._bdf[0])
        state.residual, state.marches = error, marches
        return state

    def _parts(self, change: Array, displacement_driven: bool) -> float:
        """Number of parts into which a solve divides a change of loads, shape (n + 15,), at first."""
        n, own, change = self.parameters.tendon_count, self.parameters, np.abs(change)
        unit = own.tendon_stiffness * STRING_PART if displacement_driven else 1.0
        arm = ARM * own.length
        change[n + 3 : n + 6] /= arm  # moment
        change[n + 6 : n + 9] *= arm  # force per length
        tension, force = np.max(change[:n]) * unit, np.max(change[n:])
        return float(
            max(tension / (TENSION_PER_PART * own.tension_scale), force / (FORCE_PER_PART * own.force_scale), 1.0)
        )
