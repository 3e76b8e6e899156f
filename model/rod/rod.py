"""A tendon-driven Cosserat rod: statics, time steps, tip, tendons, shape and sensitivities.

rod = Rod(RodParameters())
state = rod.solve_static(tensions=[1.0, 0.0, 0.0, 0.0])
for _ in range(100):
    state = rod.step(state, tensions=[5.0, 0.0, 0.0, 0.0])
print(rod.tip(state).position, rod.displacements(state))
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.numerics.compile import Bound
from tendond.model.rod.centerline import hermite_curve
from tendond.model.rod.discretisation import RESIDUAL_TOLERANCE, bdf_alpha, discretise, gravity_loads
from tendond.model.rod.loads import ZERO, pack_loads, push_shape, tendon_commands
from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.prediction import Scratch, TipPrediction, predict_tip
from tendond.model.rod.sensitivity import Sensitivity, tip_sensitivity, velocity_jacobian
from tendond.model.rod.state import RodState, blank_state
from tendond.model.rod.tip import Tip, tip_quantities
from tendond.model.rod.tip_body import TipBody
from tendond.model.solver.predictor import RING
from tendond.model.solver.problem import HISTORY, Problem, Profile
from tendond.model.solver.schemes import DEFAULT, Scheme, scheme
from tendond.model.solver.shooting import SOLVED
from tendond.model.solver.timestep import advance, relax
from tendond.model.solver.work import LANES, new_work

Array = NDArray[np.float64]

STATIC_TENSION_PER_PART = 10.0
"""Tension that a static solve tries to take at once [N]: only a start, for the continuation halves and doubles it."""

STATIC_FORCE_PER_PART = 1.0
"""Force on the rod, likewise [N]."""


class Rod:
    """A rod with its discretisation in space and time. Not for use by two threads at once: it has scratch memory.

    Args:
        parameters: of the rod.
        space: name of the space scheme (see `schemes`), or a `Scheme`.
        nodes: base and tip included; the scheme's own number by default.
        time_step: [s].
        alpha: of BDF-alpha, in (-0.5, 0]; 0 is BDF2, -0.5 the trapezoidal rule.
        tolerance: residual norm at which a step counts as solved [N, N m].

    Raises:
        ParameterError: a value out of range.
    """

    def __init__(
        self,
        parameters: RodParameters,
        space: str | Scheme = DEFAULT,
        nodes: int | None = None,
        time_step: float = 0.01,
        alpha: float = -0.2,
        tolerance: float = RESIDUAL_TOLERANCE,
    ) -> None:
        self.parameters = parameters
        self.scheme = scheme(space) if isinstance(space, str) else space
        self.nodes = self.scheme.nodes if nodes is None else nodes
        self.time_step = time_step
        self._data = discretise(parameters, self.scheme, self.nodes, tolerance)
        self._bdf = bdf_alpha(time_step, alpha)
        n, self._stages = parameters.tendon_count, len(self._data.push)
        self._work = new_work(n, len(self.scheme.weights), parameters.length)
        self._no_history = np.zeros((self._stages, HISTORY))
        self._loads = np.zeros(n + 15)
        self._weight = gravity_loads(parameters)
        self._predicted_loads = self._weight.copy()
        self._scratch = Scratch(np.empty((self._stages, HISTORY)), self._new_profile(), np.zeros((6, LANES)))
        self._advance, self._relax, self._tip = Bound(advance), Bound(relax), Bound(tip_quantities)
        self._predict = Bound(predict_tip)
        self._sensitivity, self._velocity_jacobian = Bound(tip_sensitivity), Bound(velocity_jacobian)

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
                first = 1.0 / self._static_parts(target - state.loads, displacement_driven)
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

    def _static_parts(self, change: Array, displacement_driven: bool) -> float:
        """Number of parts into which a static solve divides a change of loads, shape (n + 15,), at first."""
        n, change = self.parameters.tendon_count, np.abs(change)
        unit = self.parameters.tendon_stiffness * 0.01 if displacement_driven else 1.0
        tension, force = np.max(change[:n]) * unit, np.max(change[n:])
        return float(max(tension / STATIC_TENSION_PER_PART, force / STATIC_FORCE_PER_PART, 1.0))

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
            state: of this rod; on failure it is as it was, but for the carried Jacobian.
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

    def spread_push(self, place: float, half_width: float = 0.05) -> None:
        """Spread the push of later solutions over a stretch of the rod, as a parabola whose integral is the force.

        Args:
            place: of its middle, as a part of the length, in [0, 1].
            half_width: of the stretch, likewise; at least half a node's distance, so that every scheme sees it.

        Raises:
            ParameterError: a place off the rod, or no width.
        """
        self._data.push[:-1] = push_shape(self.scheme, self.nodes, self._data.ds, place, half_width)
        self._data.push[-1] = 0.0

    def load_tip(self, mass: float, inertia: ArrayLike = ZERO, offset: ArrayLike = ZERO) -> None:
        """Add a rigid body to the tip of later solutions, beside the parameters' own: it moves with the tip.

        Args:
            mass: [kg]; 0 takes it off again.
            inertia: diagonal about its centre of mass, body frame [kg m^2], shape (3,).
            offset: from the tip to its centre of mass, body frame [m], shape (3,).

        Raises:
            ParameterError: a negative or non-finite mass or inertia.
        """
        own, n = self.parameters, self.parameters.tendon_count
        body = TipBody(own.tip_mass, np.asarray(own.tip_inertia), np.asarray(own.tip_offset))
        body += TipBody.checked(mass, inertia, offset)
        record = self._data.constants
        record["tip_mass"], record["tip_offset"], record["tip_inertia"] = body.mass, body.offset, body.inertia
        self._weight[n : n + 3] = body.mass * np.asarray(own.gravity)

    def _check(self, state: RodState) -> None:
        """Refuse a state of another rod: kernels do not check bounds."""
        if state.levels.shape[1] != self._stages or state.unknowns.shape[1] != 6 + self.parameters.tendon_count:
            raise ParameterError("the state is of another rod: its scheme, nodes or tendons differ")

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

    def displacements(self, state: RodState, *, elastic: bool = False) -> Array:
        """Displacement of each tendon out of the base [m], shape (n,): rod length minus path length.

        Args:
            state: of this rod.
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
            state: of this tension-driven rod, before the step.
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
            state: of this rod.
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

    def _new_profile(self) -> Profile:
        """Memory for the state along the rod."""
        return Profile(np.empty((self._stages, HISTORY)), np.empty((self.nodes, 12)))

    def loads(
        self,
        actuation: ArrayLike,
        tip_force: ArrayLike = ZERO,
        tip_moment: ArrayLike = ZERO,
        distributed_force: ArrayLike = ZERO,
        distributed_moment: ArrayLike = ZERO,
        push: ArrayLike = ZERO,
    ) -> Array:
        """Pack loads as `advance` takes them, with gravity, shape (n + 15,).

        Raises:
            ParameterError: loads of the wrong shape or not finite.
        """
        parts = (actuation, tip_force, tip_moment, distributed_force, distributed_moment, push)
        return pack_loads(self.parameters.tendon_count, self._weight, parts)
