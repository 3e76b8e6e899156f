"""A tendon-driven Cosserat rod: statics, time steps, tip, tendons, shape and sensitivities.

rod = Rod(RodParameters())
state = rod.solve_static(tensions=[1.0, 0.0, 0.0, 0.0])
for _ in range(100):
    state = rod.step(state, tensions=[5.0, 0.0, 0.0, 0.0])
print(rod.tip(state).position, rod.displacements(state))
"""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.numerics.compile import bind
from tendond.model.rod.centerline import hermite_curve
from tendond.model.rod.loads import ZERO, pack_loads, push_shape, tendon_commands
from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.prediction import TipPrediction, predict_tip
from tendond.model.rod.sensitivity import Sensitivity, tip_sensitivity, velocity_jacobian
from tendond.model.rod.state import RodState
from tendond.model.rod.tip import Tip, tip_quantities
from tendond.model.solver.march import HISTORY
from tendond.model.solver.predictor import RING
from tendond.model.solver.schemes import DEFAULT, Scheme, scheme
from tendond.model.solver.shooting import SOLVED, RodData
from tendond.model.solver.timestep import advance, relax
from tendond.model.solver.work import LANES, new_work

Array = NDArray[np.float64]

RESIDUAL_TOLERANCE = 1e-6
MARCH_BUDGET = 60
STATIC_TENSION_PER_PART = 10.0  # [N] that a static solve from scratch tries to take at once
STATIC_FORCE_PER_PART = 1.0  # [N]


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
        if self.nodes < 2:
            raise ParameterError(f"nodes = {self.nodes} must be 2 or more")
        if not 0.0 < time_step < math.inf:
            raise ParameterError(f"time_step = {time_step} must be above 0 s")
        if not 0.0 < tolerance < math.inf:
            raise ParameterError(f"tolerance = {tolerance} must be above 0 N")
        if not -0.5 <= alpha <= 0.0:
            raise ParameterError(f"alpha = {alpha} must lie in [-0.5, 0]")
        n, s = parameters.tendon_count, len(self.scheme.weights)
        tableau, weights = self.scheme.arrays()
        self._data = RodData(
            one=(0,),
            many=(0,) * LANES,
            x=tuple(float(x) for x, _ in parameters.tendon_positions),
            y=tuple(float(y) for _, y in parameters.tendon_positions),
            constants=parameters.constants(),
            tableau=tableau,
            weights=weights,
            push=np.zeros((self.nodes - 1) * s + 1),
            flags=(self.scheme.trapezoidal, self.scheme.orthonormal),
            steps=self.nodes - 1,
            ds=parameters.length / (self.nodes - 1),
            length=parameters.length,
            stiffness=parameters.tendon_stiffness,
            tolerance=tolerance,
            budget=MARCH_BUDGET,
        )
        self._work = new_work(n, s)
        self._stages = (self.nodes - 1) * s + 1
        dt = time_step
        c0 = (1.5 + alpha) / (dt * (1.0 + alpha))
        self._bdf = (c0, -2.0 / dt, (0.5 + alpha) / (dt * (1.0 + alpha)), alpha / (1.0 + alpha))
        self._no_history = np.zeros((self._stages, HISTORY))
        self._loads = np.zeros(n + 15)
        self._weight = np.zeros(n + 15)
        self._weight[n : n + 3] = parameters.tip_mass * np.asarray(parameters.gravity)
        self._weight[n + 6 : n + 9] = parameters.mass_per_length * np.asarray(parameters.gravity)
        self._ahead = (
            self._weight.copy(), np.empty((self._stages, HISTORY)), np.empty((self._stages, HISTORY)),
            np.empty((self.nodes, 12)), np.zeros((6, LANES)),
        )  # fmt: skip
        self._advance: Any = None
        self._relax: Any = None
        self._tip: Any = None
        self._predict: Any = None
        self._velocity_jacobian: Any = None

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
        """Equilibrium at rest, reached by continuation in the loads from `start`, or from the straight, unloaded rod.

        Args:
            tensions: [N], shape (n,); none of them negative. Give these or `displacements`.
            displacements: commanded displacement of each tendon's end [m], shape (n,): the tendon is an elastic string,
                T = max(0, k (commanded - d)).
            tip_force, tip_moment: world frame [N], [N m].
            distributed_force, distributed_moment: beside gravity, world frame [N/m], [N].
            push: force spread as `spread_push` says, world frame [N].
            start: a neighbouring equilibrium of this rod, driven in the same way.

        Raises:
            ParameterError: loads of the wrong shape, not finite, negative tensions; a `start` of another rod or drive.
            ConvergenceError: no equilibrium was found.
        """
        actuation, displacement_driven = tendon_commands(self.parameters.tendon_count, tensions, displacements)
        loads = self.loads(actuation, tip_force, tip_moment, distributed_force, distributed_moment, push)
        n = self.parameters.tendon_count
        m = 6 + n
        jacobian, lengths = np.zeros((m, m)), np.zeros(n)
        levels, geometries = np.zeros((3, self._stages, HISTORY)), np.zeros((2, self.nodes, 12))
        if start is not None and start.displacement_driven is not displacement_driven:
            raise ParameterError(
                "start is driven in the other way: give an equilibrium under tensions or displacements"
            )
        # Straight to the loads first; where that leads into a fold, the tendons alone, or all but the tendons, before.
        tendons_first, tendons_last = loads.copy(), loads.copy()
        tendons_first[n : n + 6], tendons_last[:n] = 0.0, 0.0
        ways = [[loads]] if start is not None else [[loads], [tendons_first, loads], [tendons_last, loads]]
        marches = 0
        for way in ways:
            unknown, past = np.zeros(m), np.zeros(n + 15)
            if start is not None:
                self._check(start)
                unknown, past = start.unknowns[start.count % RING].copy(), start.loads
            for target in way:
                change = np.abs(target - past)
                unit = self.parameters.tendon_stiffness * 0.01 if displacement_driven else 1.0
                tension, force = np.max(change[:n]) * unit, np.max(change[n:])
                parts = max(tension / STATIC_TENSION_PER_PART, force / STATIC_FORCE_PER_PART, 1.0)
                arguments = (
                    self._data, self._work, displacement_driven, 1.0 / parts, unknown, past, target, lengths,
                    self._no_history, levels[0], geometries[0], jacobian,
                )  # fmt: skip
                if self._relax is None:
                    self._relax = bind(relax, *arguments)
                status, error, more = self._relax(*arguments)
                marches += more
                past = target
                if status != SOLVED:
                    break
            if status == SOLVED:
                break
            jacobian[:] = 0.0
        if status != SOLVED:
            raise ConvergenceError("statics did not converge", 0.0, error, marches)
        levels[1:] = levels[0]
        geometries[1] = geometries[0]
        jacobian[:] = 0.0
        return RodState(
            count=0,
            time=0.0,
            displacement_driven=displacement_driven,
            levels=levels,
            histories=np.stack([-self._bdf[0] * levels[0]] * 2),
            geometries=geometries,
            unknowns=np.stack([unknown] * RING),
            loads=loads,
            lengths=lengths,
            jacobian=jacobian,
            residual=error,
            marches=marches,
        )

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
        """The state one time step later, under the given loads; `state` stays as it is.

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
        """Advance `state` in place, with nothing allocated: `step` for those who count microseconds.

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
        arguments = (
            self._data, self._work, self._bdf, displacement_driven, state.count, state.levels, state.histories,
            state.geometries, state.unknowns, state.loads, self._loads, state.lengths, state.jacobian,
        )  # fmt: skip
        if self._advance is None:
            self._advance = bind(advance, *arguments)
        status, error, marches = self._advance(*arguments)
        if status != SOLVED:
            state.jacobian[:] = 0.0
            if displacement_driven is not drive:
                state.displacement_driven, state.loads[:] = drive, commands
            raise ConvergenceError("a time step did not converge", state.time + self.time_step, error, marches)
        state.count += 1
        state.time += self.time_step
        state.loads[:] = self._loads
        state.residual = error
        state.marches = marches

    def spread_push(self, place: float, half_width: float = 0.05) -> None:
        """Where the push of later solutions acts: on a stretch of the rod, as a parabola; its integral is the force.

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
        J, c = np.asarray(inertia, dtype=np.float64), np.asarray(offset, dtype=np.float64)
        if not (0.0 <= mass < math.inf and np.all(J >= 0.0) and np.all(np.isfinite(J)) and np.all(np.isfinite(c))):
            raise ParameterError(f"a body of {mass} kg on the tip must have a finite mass and inertia, not below 0")
        total = own.tip_mass + mass
        J0, c0 = np.asarray(own.tip_inertia), np.asarray(own.tip_offset)
        centre = (own.tip_mass * c0 + mass * c) / total if total > 0.0 else np.zeros(3)
        record = self._data.constants
        record["tip_mass"], record["tip_offset"] = total, centre
        # Parallel axes; products of inertia are left out: bodies lie on the rod's axis, or are small beside the rod.
        record["tip_inertia"] = (
            J0 + own.tip_mass * _square_distance(c0 - centre) + J + mass * _square_distance(c - centre)
        )
        self._weight[n : n + 3] = total * np.asarray(own.gravity)

    def _check(self, state: RodState) -> None:
        """Kernels do not check bounds: a state of another rod must not reach them."""
        if state.levels.shape[1] != self._stages or state.unknowns.shape[1] != 6 + self.parameters.tendon_count:
            raise ParameterError("the state is of another rod: its scheme, nodes or tendons differ")

    def _drive_by(self, state: RodState, displacement_driven: bool) -> None:
        """Express the tendons' last commands in the other way: the same state, reached by the other drive."""
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
        arguments = (
            self._data, self._bdf[0], state.levels[state.count % 3, -1], state.histories[state.count % 2, -1],
            state.geometries[state.count % 2, -1], out,
        )  # fmt: skip
        if self._tip is None:
            self._tip = bind(tip_quantities, *arguments)
        self._tip(*arguments)
        return Tip(
            position=out[:3],
            rotation=out[3:12].reshape(3, 3),
            velocity=out[12:15],
            acceleration=out[15:18],
            input_gain=out[18:].reshape(3, -1),
            tension=state.tensions,
        )

    def curve(self, state: RodState, points: int = 50) -> Array:
        """The backbone from base to tip for the eye: equally spaced points, world frame [m], shape (points, 3)."""
        strains = state.levels[state.count % 3, :: len(self.scheme.weights), :3]
        return hermite_curve(state.geometries[state.count % 2], strains, self._data.ds, points)

    def node_positions(self, state: RodState) -> Array:
        """Nodes of the backbone from base to tip, world frame [m], shape (nodes, 3); not a copy."""
        return np.asarray(state.geometries[state.count % 2][:, :3])

    def displacements(self, state: RodState, *, elastic: bool = False) -> Array:
        """How far each tendon is pulled out of the base [m], shape (n,): rod length minus path length.

        Args:
            state: of this rod.
            elastic: add the tendon's own stretch T/k.
        """
        shortening = self.parameters.length - state.lengths
        return shortening + state.tensions / self.parameters.tendon_stiffness if elastic else shortening

    def sensitivity(self, state: RodState) -> Sensitivity:
        """Derivatives of the tip against the last step's tendon commands and tip force (of a static state: of statics).

        Raises:
            ConvergenceError: the equations are singular there.
        """
        n, m = self.parameters.tendon_count, 6 + self.parameters.tendon_count
        history = state.histories[state.count % 2] if state.count else self._no_history
        actuation, force = np.zeros((6, n)), np.zeros((6, 3))
        solvable = tip_sensitivity(
            self._data, self._work, self._bdf[0] if state.count else 0.0, state.displacement_driven,
            state.unknowns[state.count % RING], state.loads, history, np.empty((self._stages, HISTORY)),
            np.empty((self.nodes, 12)), np.zeros((m, m)), actuation, force,
        )  # fmt: skip
        if not solvable:
            raise ConvergenceError("the sensitivities are singular", state.time, state.residual, state.marches)
        return Sensitivity(actuation[:3], actuation[3:], force[:3], force[3:])

    def predict(self, state: RodState, tensions: Array, ways: Array, tip_force: Array) -> TipPrediction:
        """The tip after the coming step, and how it answers to two ways to pull; no solve, see `rod.prediction`.

        Args:
            state: of this tension-driven rod, before the step.
            tensions: [N], shape (n,). tip_force: world frame [N], shape (3,).
            ways: tensions that change together, per unit of each way, shape (2, n), C-contiguous.

        Raises:
            ParameterError: a state of another rod.
            ConvergenceError: the equations are singular there.
        """
        self._check(state)
        n = self.parameters.tendon_count
        loads, history, level, geometry, jacobian = self._ahead
        loads[:n], loads[n : n + 3] = tensions, tip_force
        loads[n : n + 3] += self._weight[n : n + 3]
        tip, answer = np.zeros(9), np.zeros((9, 2))
        arguments = (
            self._data, self._work, self._bdf, state.count, state.levels, state.histories, state.unknowns, loads, ways,
            history, level, geometry, jacobian, tip, answer,
        )  # fmt: skip
        if self._predict is None:
            self._predict = bind(predict_tip, *arguments)
        if not (self._predict(*arguments) and np.isfinite(tip).all() and np.isfinite(answer).all()):
            raise ConvergenceError("the coming step is singular", state.time, state.residual, state.marches)
        return TipPrediction(tip[:3], tip[3:6], tip[6:], answer[:3], answer[6:])

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
        response = np.zeros(3)
        if state.count:
            arguments = (
                self._data, self._work, self._bdf[0], tendon, state.unknowns[state.count % RING], state.loads,
                state.histories[state.count % 2], state.levels[(state.count + 1) % 3],
                state.geometries[(state.count + 1) % 2], response,
            )  # fmt: skip
            if self._velocity_jacobian is None:
                self._velocity_jacobian = bind(velocity_jacobian, *arguments)
            if not self._velocity_jacobian(*arguments):
                response[:] = 0.0
        return response

    def loads(
        self,
        actuation: ArrayLike,
        tip_force: ArrayLike = ZERO,
        tip_moment: ArrayLike = ZERO,
        distributed_force: ArrayLike = ZERO,
        distributed_moment: ArrayLike = ZERO,
        push: ArrayLike = ZERO,
    ) -> Array:
        """The loads as `advance` takes them, gravity added, shape (n + 15,).

        Raises:
            ParameterError: loads of the wrong shape or not finite.
        """
        parts = (actuation, tip_force, tip_moment, distributed_force, distributed_moment, push)
        return pack_loads(self.parameters.tendon_count, self._weight, parts)


def _square_distance(arm: Array) -> Array:
    """Squared distance of a point from each body axis [m^2], shape (3,)."""
    x, y, z = arm.tolist()
    return np.array([y * y + z * z, x * x + z * z, x * x + y * y])
