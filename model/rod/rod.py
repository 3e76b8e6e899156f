"""A tendon-driven Cosserat rod: statics, time steps, tip, tendons, shape and sensitivities.

rod = Rod(RodParameters())
state = rod.solve_static(tensions=[1.0, 0.0, 0.0, 0.0])
for _ in range(100):
    state = rod.step(state, tensions=[5.0, 0.0, 0.0, 0.0])
print(rod.tip(state).position, rod.displacements(state))
"""

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.numerics.compile import Bound
from tendond.model.rod.centerline import hermite_curve
from tendond.model.rod.loads import ZERO, tendon_commands
from tendond.model.rod.prediction import TipPrediction, predict_tip
from tendond.model.rod.sensitivity import Sensitivity, tip_sensitivity, velocity_jacobian
from tendond.model.rod.state import RodState
from tendond.model.rod.statics import StaticRod
from tendond.model.rod.tip import Tip, tip_quantities
from tendond.model.solver.predictor import RING
from tendond.model.solver.problem import Problem
from tendond.model.solver.shooting import SOLVED
from tendond.model.solver.timestep import advance

Array = NDArray[np.float64]


class Rod(StaticRod):
    """A rod with its discretisation in space and time: statics, time steps, and what follows from a solution.

    Not for use by two threads at once: it has scratch memory.

    Args:
        parameters: parameters of the rod.
        space: name of the space scheme (see `schemes`), or a `Scheme`.
        nodes: base and tip included; the scheme's own number by default.
        time_step: [s].
        alpha: parameter of BDF-alpha, in (-0.5, 0]; 0 is BDF2, -0.5 the trapezoidal rule.
        tolerance: residual norm at which a step counts as solved [N], with moments at the arm `solver.shooting.ARM`;
            1e-6 N on the paper's robot by default, on others in proportion to EI/L^2.

    Raises:
        ParameterError: a value out of range.
    """

    whole_steps = False

    _advance = cached_property(lambda self: Bound(advance))
    _tip = cached_property(lambda self: Bound(tip_quantities))
    _predict = cached_property(lambda self: Bound(predict_tip))
    _sensitivity = cached_property(lambda self: Bound(tip_sensitivity))
    _velocity_jacobian = cached_property(lambda self: Bound(velocity_jacobian))

    @property
    def arm_stiffness(self) -> float:
        """EI [N m^2]: nodes are evenly spaced, so equal parts of the compliance lie between them."""
        return self.parameters.bending_stiffness

    @property
    def tendon_stiffness(self) -> float:
        """Stiffness of each tendon [N/m]."""
        return self.parameters.tendon_stiffness

    def step(
        self,
        state: RodState,
        tensions: ArrayLike | None = None,
        *,
        displacements: ArrayLike | None = None,
        tip_force: ArrayLike = ZERO,
        tip_moment: ArrayLike = ZERO,
        distributed_force: ArrayLike = ZERO,
        distributed_moment: ArrayLike = ZERO,
        push: ArrayLike = ZERO,
    ) -> RodState:
        """Compute the state one time step later, under the given loads; `state` is not changed.

        Arguments as in `solve_static`.

        Raises:
            ParameterError: loads of the wrong shape, not finite, or a negative tension; a state of another rod.
            ConvergenceError: the step was not solved.
        """
        actuation, displacement_driven = tendon_commands(self.parameters.tendon_count, tensions, displacements)
        loads = self.loads(actuation, tip_force, tip_moment, distributed_force, distributed_moment, push)
        self._check(state)
        new = state.successor()
        self.advance(new, loads, displacement_driven)
        return new

    def advance(self, state: RodState, loads: Array, displacement_driven: bool = False) -> None:
        """Advance `state` in place, with nothing allocated: a `step` without its copy of the state.

        Args:
            state: state of this rod; on failure it is as it was, but for the carried Jacobian.
            loads: tensions [N] (or displacements [m]), tip force, tip moment, distributed force with gravity's share,
                distributed moment, push; shape (n + 15,).
            displacement_driven: see `solve_static`.

        Raises:
            ParameterError: a state of another rod.
            ConvergenceError: the step was not solved.
        """
        self._check(state)
        self._loads[:] = loads
        drive = state.displacement_driven
        if displacement_driven is not drive:
            commands = state.loads.copy()
            self._drive_by(state, displacement_driven)
        status, error, marches = self._advance.call(self._data, self._work, self._bdf, state.data(), self._loads)
        if status != SOLVED:
            state.jacobian[:] = 0.0
            if displacement_driven is not drive:
                state.displacement_driven, state.loads[:] = drive, commands
            raise ConvergenceError("a time step did not converge", state.time + self.time_step, error, marches)
        state.count += 1
        state.time += self.time_step
        state.residual = error
        state.marches = marches

    def _drive_by(self, state: RodState, displacement_driven: bool) -> None:
        """Express the tendons' last commands as displacements, or as tensions, in the same state."""
        n = self.parameters.tendon_count
        state.loads[:n] = self.displacements(state, elastic=True) if displacement_driven else state.tensions
        state.displacement_driven = displacement_driven
        state.jacobian[:] = 0.0

    def tip(self, state: RodState) -> Tip:
        """The tip after the last step.

        Raises:
            ParameterError: a state of another rod.
        """
        self._check(state)
        out = np.empty(18 + 3 * self.parameters.tendon_count)
        self._tip.call(
            self._data, self._bdf[0], state.levels[state.count % 3, -1], state.histories[state.count % 2, -1],
            state.geometries[state.count % 2, -1], out,
        )  # fmt: skip
        return Tip(
            position=out[:3],
            rotation=out[3:12].reshape(3, 3),
            velocity=out[12:15],
            acceleration=out[15:18],
            input_gain=out[18:].reshape(3, -1),
            tension=state.tensions,
        )

    def curve(self, state: RodState, points: int = 50) -> Array:
        """The backbone from base to tip, for display: equally spaced points, world frame [m], shape (points, 3)."""
        strains = state.levels[state.count % 3, :: len(self.scheme.weights), :3]
        return hermite_curve(state.geometries[state.count % 2], strains, self._data.ds, points)

    def node_positions(self, state: RodState) -> Array:
        """Nodes of the backbone from base to tip, world frame [m], shape (nodes, 3); not a copy."""
        return np.asarray(state.geometries[state.count % 2][:, :3])

    def tendon_paths(self, state: RodState, points: int = 10) -> list[Array]:
        """Points of each tendon, for display, world frame [m], shape (points, 3) each."""
        curve, rotations, nodes = self.curve(state, points), state.rotations, np.linspace(0.0, 1.0, self.nodes)
        at = np.linspace(0.0, 1.0, points)
        paths = []
        for x, y in self.parameters.tendon_positions:
            arms = rotations[:, :, 0] * x + rotations[:, :, 1] * y
            paths.append(curve + np.stack([np.interp(at, nodes, arms[:, axis]) for axis in range(3)], axis=1))
        return paths

    def displacements(self, state: RodState, *, elastic: bool = False) -> Array:
        """Displacement of each tendon out of the base [m], shape (n,): rod length minus path length.

        Args:
            state: state of this rod.
            elastic: add the tendon's own stretch T/k.
        """
        shortening = self.parameters.length - state.lengths
        return shortening + state.tensions / self.parameters.tendon_stiffness if elastic else shortening

    def sensitivity(self, state: RodState) -> Sensitivity:
        """Jacobians of the tip by the last step's tendon commands and tip force (of a static state: of statics).

        Raises:
            ConvergenceError: the equations are singular there.
        """
        n, m = self.parameters.tendon_count, 6 + self.parameters.tendon_count
        history = state.histories[state.count % 2] if state.count else self._no_history
        problem = Problem(self._bdf[0] if state.count else 0.0, state.displacement_driven, state.loads, history)
        actuation, force = np.zeros((6, n)), np.zeros((6, 3))
        solvable = self._sensitivity.call(
            self._data, self._work, problem, state.unknowns[state.count % RING], self._new_profile(), np.zeros((m, m)),
            actuation, force,
        )  # fmt: skip
        if not solvable:
            raise ConvergenceError("the sensitivities are singular", state.time, state.residual, state.marches)
        return Sensitivity(actuation[:3], actuation[3:], force[:3], force[3:])

    def predict(self, state: RodState, tensions: Array, inputs: Array, tip_force: Array) -> TipPrediction:
        """Predict the tip after the coming step, and its jacobian by two combinations of tensions, without a solve.

        See `rod.prediction`.

        Args:
            state: state of this tension-driven rod, before the step.
            tensions: [N], shape (n,). tip_force: world frame [N], shape (3,).
            inputs: combinations of tensions, in each row the tensions per unit of one, shape (2, n), C-contiguous.

        Raises:
            ParameterError: a state of another rod.
            ConvergenceError: the equations are singular there.
        """
        self._check(state)
        n, loads = self.parameters.tendon_count, self._predicted_loads
        loads[:n], loads[n : n + 3] = tensions, tip_force
        loads[n : n + 3] += self._weight[n : n + 3]
        tip, jacobian = np.zeros(9), np.zeros((9, 2))
        solvable = self._predict.call(
            self._data, self._work, self._bdf, state.data(), loads, inputs, self._scratch, tip, jacobian
        )
        if not (solvable and np.isfinite(tip).all() and np.isfinite(jacobian).all()):
            raise ConvergenceError("the coming step is singular", state.time, state.residual, state.marches)
        return TipPrediction(tip[:3], tip[3:6], tip[6:], jacobian[:3], jacobian[6:])

    def velocity_jacobian(self, state: RodState, tendon: int) -> Array:
        """A column of `sensitivity().velocity_actuation`, of a tension-driven rod, in less than half of its time.

        Args:
            state: state of this rod.
            tendon: index.

        Returns:
            d(tip velocity after the last step)/d(its tension), world frame [m/s/N], shape (3,); zeros at a static state
            and where the equations are singular.

        Raises:
            ParameterError: a state of another rod; no such tendon.
        """
        self._check(state)
        if not 0 <= tendon < self.parameters.tendon_count:
            raise ParameterError(f"tendon = {tendon}: the rod has tendons 0 to {self.parameters.tendon_count - 1}")
        column = np.zeros(3)
        if state.count and not self._velocity_jacobian.call(
            self._data, self._work, self._bdf, state.data(), tendon, column
        ):
            column[:] = 0.0
        return column
