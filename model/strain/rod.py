"""The general rod: statics, time steps, tip, shape and stability of a robot, from one description."""

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import eigh

from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.numerics.compile import Bound
from tendond.model.strain.describe.base import Base
from tendond.model.strain.describe.configured import described
from tendond.model.strain.discretise.places import Places
from tendond.model.strain.friction.hold import hold, hold_profiles
from tendond.model.strain.friction.statics import FrictionStatics, pulls_of
from tendond.model.strain.kinematics import Shape, empty_shape, find_shape
from tendond.model.strain.layout import Layout, lay_out
from tendond.model.strain.loads import Distributed, Drive, Wrench, make_loads
from tendond.model.strain.minima.hessian import stiffness_of
from tendond.model.strain.minima.minimise import ITERATIONS, minimise
from tendond.model.strain.robot import Body, Robot
from tendond.model.strain.state import StrainState, trend_of
from tendond.model.strain.stepping.advance import advance
from tendond.model.strain.stepping.carried import put_base
from tendond.model.strain.stepping.energies import energies
from tendond.model.strain.stepping.mass import mass_matrix
from tendond.model.strain.stepping.scratch import Loads, mirrored, scratch_for
from tendond.model.strain.tendons import empty_paths, find_paths
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.robot import RodSection

Array = NDArray[np.float64]
Index = NDArray[np.int64]

STATIC_TOLERANCE = 1e-10
"""Tolerance of a rest [rad], as that of a step: a hundredth of it. Chosen; `pytest
tests/unit/strain/test_dynamics.py -k changes_nothing` steps from a rest and stays there."""

STEP_TOLERANCE = 1e-8
"""Tolerance of the strains [rad]: relative to the energy of the robot's softest section when bent by 1 rad. Chosen;
`tendond bench rod --references` has the errors that remain."""


class StrainRod:
    """A robot as a rod in strain coordinates.

    Args:
        robot: its description.
        time_step: of `step` [s].
        stations: arc lengths at which loads may act besides the ends of sections and the bodies [m].

    Raises:
        ParameterError: a robot that cannot be.
    """

    def __init__(self, robot: Robot, time_step: float = 0.01, stations: Sequence[float] = ()) -> None:
        if not (np.isfinite(time_step) and time_step > 0.0):
            raise ParameterError(f"time_step = {time_step!r} must be finite and above 0")
        self.robot = robot
        self.time_step = time_step
        self.layout: Layout = lay_out(replace(robot, bodies=(*robot.bodies, *(Body(at, 0.0) for at in stations))))
        self.node = Places(self.layout).node  # (node, mass point on the backbone) at an arc length [m]
        self._work = scratch_for(self.layout)
        self._next = mirrored(self._work)
        self._moved = False  # whether the arrays hold another base than the robot's
        self._last: StrainState | None = None  # whose shape is in `_work.after`
        self._advance, self._minimise = Bound(advance), Bound(minimise)
        self._shape = empty_shape(self.layout)
        self._shaped: StrainState | None = None  # whose shape that is
        self._paths = empty_paths(self.layout)
        self._rubbing: Index = self._work.grip.tendon  # tendons with friction
        self._statics = FrictionStatics(self.layout, self._work, STATIC_TOLERANCE)

    @staticmethod
    def from_config(source: RigConfig | RodSection | str | Path, time_step: float | None = None) -> "StrainRod":
        """Return the rod of a configuration.

        Args:
            source: a configuration, its [rod], a file's path, or the name of a preset.
            time_step: of `step` [s]; default: loop.period of a whole configuration, else 0.01.

        Raises:
            ConfigError: the file cannot be read or is invalid.
            ParameterError: a robot that cannot be.
        """
        robot, period = described(source)
        return StrainRod(robot, period if time_step is None else time_step)

    @property
    def modes(self) -> int:
        """Number of strain modes, n."""
        return len(self.layout.component)

    def loads(
        self,
        tension: Drive = None,
        displacement: Drive = None,
        tip_force: ArrayLike = (0.0, 0.0, 0.0),
        wrenches: Sequence[Wrench] = (),
        distributed: Sequence[Distributed] = (),
    ) -> Loads:
        """Return what acts on the robot.

        Args:
            tension: of each tendon [N], not negative, shape (m,); default: none.
            displacement: of each tendon [m], shape (m,), for elastic tendons; a tendon never pushes. Both together:
                each tendon has a number in one of them, and None in the other.
            tip_force: dead force on the tip, world frame [N], shape (3,).
            wrenches: dead forces [N] and moments [N m], world frame, at arc lengths [m] where the robot has a node: the
                ends of sections, bodies, and the rod's stations.
            distributed: dead forces per length [N/m] and moments per length [N], world frame, from an arc length to
                another [m].

        Raises:
            ParameterError: not finite, of another shape, a negative tension, an inextensible tendon driven by
                displacement, or a place that is not on the robot.
        """
        given = tension, displacement, tip_force, wrenches, distributed
        return make_loads(self.layout, self.robot, self.node, *given)

    def rest(self) -> StrainState:
        """Return the unloaded reference shape, at rest."""
        return StrainState(np.zeros(self.modes), np.zeros(self.modes))

    def solve_static(self, loads: Loads, start: StrainState | None = None, base: Base | None = None) -> StrainState:
        """Return a stable equilibrium, downhill from `start` (default: the reference shape), in the pose of `base`.

        Raises:
            ConvergenceError: none was found.
        """
        q = self.rest().strain if start is None else start.strain.copy()
        self._last = None
        rest = None if base is None else base.at_rest()
        self._put(rest)
        pulls, lost = None, 0.0
        if len(self._rubbing) > 0:
            before = self._work.grip.start * 0.0 if start is None or start.pulls is None else start.pulls
            count, q, pulls, lost = self._statics.solve(loads, q, before, start is None)
        else:
            count = self._minimise.call(self.layout, loads, q, 0.0, STATIC_TOLERANCE, self._work)
        if count < 0 or not np.all(np.isfinite(q)):
            raise ConvergenceError(
                "statics: no equilibrium downhill from this start", 0.0, self._residual(), ITERATIONS
            )
        return StrainState(q, np.zeros(self.modes), int(count), 0, base=rest, pulls=pulls, friction_work=lost)

    def step(self, state: StrainState, loads: Loads, base: Base | None = None) -> StrainState:
        """Return the state one time step on, under loads that are held over it.

        Args:
            state: at the start.
            loads: dead ones in the world frame, whatever the base does.
            base: at the start of the step, world frame; its accelerations [m/s^2], [rad/s^2] are held over the step.
                Default: at rest where the state's base is. Rates are those in the base's frame.

        Raises:
            ConvergenceError: not a finite state, or not finite loads.
        """
        q, w = state.strain.copy(), state.rate.copy()
        known = state is self._last
        if known:
            self._work, self._next = self._next, self._work
        self._last = None
        if base is None and state.base is not None:
            base = state.base.at_rest()
        self._put(base)
        if len(self._rubbing) > 0:
            self._work.grip.start[:] = 0.0 if state.pulls is None else state.pulls
        self._work.trend[:] = trend_of(state.earlier)
        count, steps, damped = self._advance.call(
            self.layout, loads, q, w, self.time_step, STEP_TOLERANCE, self._work, known and base is None
        )
        if not math.isfinite(q @ q + w @ w):
            raise ConvergenceError("dynamics: the step from a state, or under loads, that are not finite", 0.0, 0.0, 0)
        earlier = (state.rate, state.rate if state.earlier is None else state.earlier[0])
        ahead = None if base is None else base.after(self.time_step)
        self._last = StrainState(q, w, count, steps, damped, earlier, ahead, *pulls_of(self._work))
        return self._last

    def _put(self, base: Base | None) -> None:
        """Tell the kernels where the base is, if it is not, or was not, where the robot has it."""
        if base is not None or self._moved:
            self._moved = base is not None
            put_base(self.layout, base, self._work.before, self._work.after)
            self._work.base[:] = 0.0 if base is None else base.row()

    def shape(self, state: StrainState) -> Shape:
        """Return the shape of a state, where its base is; the next call, with another state, overwrites it."""
        if state is not self._shaped:
            put_base(self.layout, state.base, self._shape)
            find_shape(self.layout, state.strain, self._shape)
            self._shaped = state
        return self._shape

    def _residual(self) -> float:
        return float(np.max(np.abs(self._work.residual)))

    def tip(self, state: StrainState) -> tuple[Array, Array]:
        """Return position [m], shape (3,), and orientation of the tip, body to world, shape (3, 3)."""
        shape = self.shape(state)
        return shape.position[-1].copy(), shape.rotation[-1].reshape(3, 3).copy()

    def tip_velocity(self, state: StrainState) -> Array:
        """Return velocity of the tip, world frame [m/s], shape (3,)."""
        own = np.asarray(self.tip_jacobian(state) @ state.rate)
        return own if state.base is None else own + state.base.velocity_at(self._shape.position[-1])

    def tip_jacobian(self, state: StrainState) -> Array:
        """Return the derivative of the tip's position to the strains, world frame, shape (3, n)."""
        shape = self.shape(state)
        twist = shape.twist[-1, :, : self.modes]
        return np.asarray(np.cross(twist[:3], shape.position[-1], axisa=0, axisc=0) + twist[3:])

    def backbone(self, state: StrainState) -> Array:
        """Return the nodes' positions, world frame [m], shape (K + 1, 3)."""
        return self.shape(state).position.copy()

    def displacements(self, state: StrainState) -> Array:
        """Return the displacement of each tendon: shortening of its path in the robot [m], shape (m,)."""
        find_paths(self.layout, state.strain, self._paths)
        return self._paths.displacement.copy()

    def stability(self, state: StrainState, loads: Loads) -> float:
        """Return the min. eigenvalue of the tangent stiffness, relative to the unloaded robot's; negative: unstable."""
        tangent = self.tangent(state, loads)
        return float(eigh(tangent, self.layout.stiffness, eigvals_only=True)[0])

    def frequencies(self, state: StrainState, loads: Loads) -> Array:
        """Return the natural frequencies about an equilibrium, undamped, ascending [Hz], shape (n,)."""
        tangent = self.tangent(state, loads)
        lower = np.linalg.cholesky(mass_matrix(self.layout, self._work.after, self._work))
        inner = np.linalg.solve(lower, np.linalg.solve(lower, tangent).T)
        squares = np.linalg.eigvalsh(0.5 * (inner + inner.T))
        return np.asarray(np.sqrt(np.maximum(squares, 0.0)) / (2.0 * np.pi))

    def tangent(self, state: StrainState, loads: Loads) -> Array:
        """Return the tangent stiffness at a state, shape (n, n); leaves its shape in `_work.after`."""
        self._last = None
        self._put(state.base)
        held = hold(self.layout, loads, state.pulls, self._work)
        found = stiffness_of(self.layout, held, state.strain, self._work)
        hold_profiles(self.layout, None, self._work)
        return found

    def energy(self, state: StrainState) -> float:
        """Return kinetic, elastic and gravity's energy [J]."""
        return sum(energies(self.layout, self.shape(state), state.strain, state.rate, state.base))
