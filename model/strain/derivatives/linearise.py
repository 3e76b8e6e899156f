"""Linear models of the general rod: x = (q, w) after a step by x before it, tendons and loads; outputs by x; the tip.

    x1 = A x0 + B u + E f,     y = C x     (deviations from a step; u tensions or displacement commands, f loads)

For estimators, predictive laws and identification. Derivatives are analytic and exact for the discrete rod; see `step`.
Friction of tendons is held in them: `friction.hold`.
"""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.numerics.compile import Bound
from tendond.model.numerics.products import padded
from tendond.model.strain.derivatives.acceleration import accelerate, tangent_stiffness
from tendond.model.strain.derivatives.by_inputs import differentiate_inputs
from tendond.model.strain.derivatives.rates import find_rates
from tendond.model.strain.derivatives.results import InputSensitivity, Outputs, Rest, StepSensitivity, TipDynamics
from tendond.model.strain.derivatives.room import mirrored_room, room_for
from tendond.model.strain.derivatives.step import differentiate
from tendond.model.strain.friction.hold import check_drive, hold, hold_profiles, without_friction
from tendond.model.strain.kinematics import find_shape
from tendond.model.strain.rod import STEP_TOLERANCE, StrainRod
from tendond.model.strain.state import StrainState, trend_of
from tendond.model.strain.stepping.advance import advance
from tendond.model.strain.stepping.scratch import Loads, mirrored, scratch_for
from tendond.model.strain.tendons import empty_paths, find_paths

Array = NDArray[np.float64]

DIFFERENCE = 1e-5
"""Difference of strains in steps that are differenced, in the measure of energy [rad]."""

DIFFERENCE_TOLERANCE = 1e-13
"""Tolerance of solutions that are differenced: their error over the difference, 1e-8, is below the difference's own."""


class Linearisation:
    """Linear models of a rod, about any of its states.

    Args:
        rod: the general rod.
        at: arc length at which loads are differentiated, a node's [m]; default: the tip.

    Raises:
        ParameterError: there is no node at this place; from any method, a state whose base moves, or moved; from all
            but `stability`, a tendon with friction that is driven by displacement.
    """

    def __init__(self, rod: StrainRod, at: float | None = None) -> None:
        self.rod = rod
        place = rod.robot.length if at is None else at
        if not place > 0.0:
            raise ParameterError(f"linearise: at = {place!r} must lie beyond the base")
        node, point = rod.node(place)
        self._node, self._point = node, point
        self._tip = rod.node(rod.robot.length)[1]
        n, m = rod.modes, len(rod.robot.tendons)
        self._rubs = bool(np.any(rod.layout.friction > 0.0))
        self._layout = without_friction(rod.layout) if self._rubs else rod.layout
        self._paths = empty_paths(rod.layout)  # without a weight
        self._work = scratch_for(self._layout)
        self._next = mirrored(self._work)
        self._last: StrainState | None = None  # whose shape is in `_work.after`,
        self._rated = False  # and its motion in `_room.rates1`
        self._room = room_for(self._layout, (point,), (node,))
        self._next_room = mirrored_room(self._room)
        self._advance, self._differentiate = Bound(advance), Bound(differentiate)
        self._by_inputs = Bound(differentiate_inputs)
        self._by_input, self._found = np.zeros(n * padded.py_func(m + 6)), np.zeros((6 + m, m + 6))
        self._accelerations = np.zeros(n * padded.py_func(1 + m))
        self._tangent = np.zeros((n, n))

    def step(self, state: StrainState, loads: Loads) -> StepSensitivity:
        """Return the state one time step on, with its derivatives.

        Analytic where the step is solved in one piece. One that is split, or ends in a minimum, is differenced.

        Raises:
            ConvergenceError: not a finite state, or not finite loads.
        """
        n, m, h = self.rod.modes, len(self.rod.robot.tendons), self.rod.time_step
        rated = self._rated
        after, known = self._advanced(state, loads)
        analytic = after.steps == 1 and after.damped == 0
        out = np.empty((2 * n, 2 * n + m + 6))
        if analytic:
            before, known = (state.strain, state.rate), known and rated
            analytic = self._differentiate.call(self._layout, loads, *before, h, known, self._work, self._room, out)
        if analytic:
            self._last, self._rated = after, True
        else:
            out = self._differences(state, loads)
        return StepSensitivity(
            after, out[:, : 2 * n], out[:, 2 * n : 2 * n + m],
            out[:, 2 * n + m : 2 * n + m + 3], out[:, 2 * n + m + 3 :], analytic,
        )  # fmt: skip

    def inputs(self, state: StrainState, loads: Loads) -> InputSensitivity:
        """Return the state one time step on, with the tip's and the tendons' derivatives by what acts during it.

        A fraction of the price of `step`: the derivatives are those of Newton's method, see `derivatives.by_inputs`.

        Raises:
            ConvergenceError: not a finite state, or not finite loads.
        """
        rod, m = self.rod, len(self.rod.robot.tendons)
        after, _ = self._advanced(state, loads)
        analytic, found = after.steps == 1 and after.damped == 0, self._found
        if analytic:
            places, work = (self._tip, self._point, self._node), self._work
            analytic = self._by_inputs.call(self._layout, loads, rod.time_step, *places, work, self._by_input, found)
        if analytic:
            self._last, self._rated = after, False
            if self._rubs:
                find_paths(rod.layout, after.strain, self._paths)
                found[6:] = self._paths.gradient @ self._by_input.reshape(rod.modes, -1)[:, : m + 6]
        else:
            differences = self._differences(state, loads, inputs=True)
            outputs = self.outputs(after)
            rows = np.concatenate((outputs.position, outputs.rotation, outputs.displacement))
            found[:] = rows @ differences
        return InputSensitivity(after, found.copy(), analytic)

    def _advanced(self, state: StrainState, loads: Loads) -> tuple[StrainState, bool]:
        """Take a step in `_work`; return the state after it, and whether the shape before it was there already."""
        _check_base(state)
        check_drive(self.rod.layout, loads)
        pulls, lost = None, 0.0
        if self._rubs:
            real = self.rod.step(state, loads)
            pulls, lost = real.pulls, real.friction_work
            hold_profiles(self.rod.layout, pulls, self._work)
        q, w = state.strain.copy(), state.rate.copy()
        known = state is self._last and not self._rubs  # its paths have other weights
        if known:
            self._work, self._next = self._next, self._work
            self._room, self._next_room = self._next_room, self._room
        self._last = None
        self._work.trend[:] = trend_of(state.earlier)
        count, steps, damped = self._advance.call(
            self._layout, loads, q, w, self.rod.time_step, STEP_TOLERANCE, self._work, known
        )
        if not math.isfinite(q @ q + w @ w):
            raise ConvergenceError("dynamics: the step from a state, or under loads, that are not finite", 0.0, 0.0, 0)
        earlier = (state.rate, state.rate if state.earlier is None else state.earlier[0])
        return StrainState(q, w, count, steps, damped, earlier, None, pulls, lost), known

    def outputs(self, state: StrainState) -> Outputs:
        """Return the derivatives of what is measured at a state."""
        _check_base(state)
        self._last = None
        layout, work, rates = self._layout, self._work, self._room.rates1
        hold_profiles(self.rod.layout, None, work)
        n, shape = self.rod.modes, work.after
        find_shape(layout, state.strain, shape)
        find_rates(layout, state.rate, shape, self._room.bends, rates)
        find_paths(layout, state.strain, work.paths_after)
        still = np.zeros((3, n))
        moved = shape.jacobian[self._tip, :, :n].copy()
        gradient = work.paths_after.gradient
        return Outputs(
            np.hstack((moved, still)), np.hstack((shape.twist[-1, :3, :n], still)),
            np.hstack((rates.point[self._tip, :, :n], moved)), np.hstack((gradient, np.zeros_like(gradient))),
        )  # fmt: skip

    def tip(self, state: StrainState, loads: Loads) -> TipDynamics:
        """Return acceleration, a_c and b_c of the tip at a state under loads.

        Raises:
            ConvergenceError: the mass matrix is singular, or not finite.
        """
        _check_base(state)
        self._last = None
        work, rates, found = self._work, self._room.rates1, self._accelerations
        loads = hold(self.rod.layout, loads, state.pulls, self._work)
        done = accelerate(self._layout, loads, state.strain, state.rate, work, self._room, found)
        if not (done and np.all(np.isfinite(found))):
            raise ConvergenceError("dynamics: the mass matrix is singular at this state", 0.0, 0.0, 0)
        moved = work.after.jacobian[self._tip, :, : self.rod.modes]
        found = found.reshape(self.rod.modes, -1)[:, : 1 + len(work.taut)]
        drift = moved @ found[:, 0] + rates.point[self._tip, :, : self.rod.modes] @ state.rate
        gain, tension = moved @ found[:, 1:], work.taut.copy()
        return TipDynamics(drift + gain @ tension, drift, gain, tension)

    def rest(self, state: StrainState, loads: Loads) -> Rest:
        """Return the derivatives of an equilibrium.

        Raises:
            ConvergenceError: it is a fold or a bifurcation: there are none.
        """
        _check_base(state)
        self._last = None
        check_drive(self.rod.layout, loads)
        layout, work, loads = self._layout, self._work, hold(self.rod.layout, loads, state.pulls, self._work)
        tangent_stiffness(layout, loads, state.strain, work, self._room, self._tangent)
        given = np.where(loads.driven & (work.taut > 0.0), layout.tendon_stiffness, 1.0)
        given[loads.driven & (work.taut <= 0.0)] = 0.0
        node, point, n = self._node, self._point, self.rod.modes
        by_force, by_moment = work.after.jacobian[point, :, :n], work.after.twist[node, :3, :n]
        pushes = np.concatenate((given[:, None] * work.paths_after.gradient, by_force, by_moment))
        try:
            strain = np.asarray(np.linalg.solve(self._tangent, pushes.T), dtype=np.float64)
        except np.linalg.LinAlgError:
            raise ConvergenceError("statics: this equilibrium is singular", 0.0, 0.0, 0) from None
        m = len(given)
        moved, turned = work.after.jacobian[self._tip, :, :n] @ strain, work.after.twist[-1, :3, :n] @ strain
        return Rest(strain[:, :m], moved[:, :m], turned[:, :m], moved[:, m : m + 3], moved[:, m + 3 :])

    def stability(self, state: StrainState, loads: Loads) -> float:
        """Return the min. eigenvalue of the exact tangent stiffness, relative to the unloaded robot's stiffness."""
        _check_base(state)
        self._last = None
        layout, loads = self._layout, hold(self.rod.layout, loads, state.pulls, self._work)
        tangent_stiffness(layout, loads, state.strain, self._work, self._room, self._tangent)
        return float(eigh(0.5 * (self._tangent + self._tangent.T), layout.stiffness, eigvals_only=True)[0])

    def _differences(self, state: StrainState, loads: Loads, *, inputs: bool = False) -> Array:
        """Central differences of the step, as `StepSensitivity` orders them.

        `inputs`: by the inputs alone, at a fifth of the price.
        """
        rod, layout, work = self.rod, self._layout, self._work
        n, m, h = rod.modes, len(rod.robot.tendons), rod.time_step
        soft = DIFFERENCE * np.sqrt(work.unit[0] / np.diag(layout.stiffness))
        force = DIFFERENCE * work.unit[0] / rod.robot.length
        tension = np.where(loads.driven, DIFFERENCE * rod.robot.length, force)
        sizes = np.concatenate((soft, soft / h, tension, np.full(3, force), np.full(3, DIFFERENCE * work.unit[0])))
        start = np.concatenate((state.strain, state.rate, loads.tension, np.zeros(6)))
        work.trend[:] = 0.0

        def ahead(x: Array) -> Array:
            q, w = x[:n].copy(), x[n : 2 * n].copy()
            forces, moments = loads.force.copy(), loads.moment.copy()
            forces[self._point] += x[2 * n + m : 2 * n + m + 3]
            moments[self._node] += x[2 * n + m + 3 :]
            changed = loads._replace(force=forces, moment=moments, tension=x[2 * n : 2 * n + m].copy())
            advance(layout, changed, q, w, h, DIFFERENCE_TOLERANCE, work, False)
            return np.concatenate((q, w))

        columns = [
            (ahead(start + size * unit) - ahead(start - size * unit)) / (2.0 * size)
            for size, unit in list(zip(sizes, np.eye(len(start)), strict=True))[2 * n if inputs else 0 :]
        ]
        return np.stack(columns, axis=1)


def _check_base(state: StrainState) -> None:
    if state.base is not None:
        raise ParameterError("linearise: the state's base moves, or moved: derivatives are for a robot's own base")
