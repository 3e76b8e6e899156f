"""The general rod as controller and simulator run it: any robot, any damping, behind the shooting rod's interface.

What a law knows of the tip is that of whole steps: with x the tip's position,

    v(k) = (x(k) - x(k-1)) / h,    (v(k+1) - v(k)) / h = a_c + b_c T,    b_c = dx(k+1)/dT / h^2

by the derivative of the discrete step (`Linearisation.inputs`). The paper's own b_c belongs to one cross-section of
a continuous rod; it vanishes where that is straight, and for tendons that end before the tip. This one is what a
tension does to the tip within a cycle, of any robot. v is the mean velocity over a step: that at its end alternates
from step to step, as no scheme that conserves energy damps modes which are faster than the step.
"""

from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.rod.loads import ZERO
from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.prediction import TipPrediction
from tendond.model.rod.tip import Tip
from tendond.model.rods.equivalent import arm_stiffness, equivalent_rod
from tendond.model.strain.derivatives.linearise import Linearisation
from tendond.model.strain.derivatives.results import InputSensitivity
from tendond.model.strain.friction.along import stretches, tension_along
from tendond.model.strain.kinematics import Shape, empty_shape, find_shape
from tendond.model.strain.robot import Robot
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.state import StrainState
from tendond.model.strain.stepping.scratch import Loads

Array = NDArray[np.float64]

ARM_POINTS = 13
"""Points of the backbone by which the tip's compliance is summed: within 0.5 % of a cantilever's, by its (N - 1)^-2."""


@dataclass(frozen=True)
class GeneralState:
    """State of the general rod, with the loads that led to it.

    Attributes:
        strain: strains and rates.
        tensions: of the tendons, at the servos' ends [N], shape (n,). tip_force: world frame [N], shape (3,).
        position: of the tip [m]; velocity: mean of it over the last step [m/s]; world frame, shape (3,).
    """

    strain: StrainState
    tensions: Array
    tip_force: Array
    position: Array
    velocity: Array

    @property
    def residual(self) -> float:
        """Zero: a step is judged by its correction, not by a force that is missing."""
        return 0.0

    @property
    def marches(self) -> int:
        """Newton's iterations of the last solution."""
        return self.strain.iterations


class GeneralRod:
    """The general rod, driven by tensions. Not for use by two threads at once, but for what is for display.

    Args:
        robot: its description. time_step: [s].
        compliance: factor on the compliance of the whole robot [-].

    Attributes:
        robot: as given.
        parameters: of the uniform rod that stands for it, for scales. arm_stiffness: see `ModelRod`.
        tendon_stiffness: of each tendon, the shooting rod's for those that are given none [N/m], shape (n,).

    Raises:
        ParameterError: a robot that cannot be, or without a tendon.
    """

    whole_steps = True

    def __init__(self, robot: Robot, time_step: float, compliance: float = 1.0) -> None:
        self.robot = robot
        self.time_step = time_step
        self._rod = StrainRod(robot, time_step)
        self._rod.layout.stiffness[:] /= compliance
        self.parameters: RodParameters = equivalent_rod(self._rod)
        stiffness, share, places = arm_stiffness(robot)
        self.arm_stiffness = stiffness / compliance
        given = self._rod.layout.tendon_stiffness
        self.tendon_stiffness = np.where(given > 0.0, given, RodParameters.tendon_stiffness)
        self._nodes = np.concatenate(([0.0], np.cumsum(self._rod.layout.step)))
        self._arm = self._hermite(np.interp(np.linspace(0.0, 1.0, ARM_POINTS), share, places))
        self._holes = [[tendon.at(float(s)) for s in self._nodes] for tendon in robot.tendons]
        self._free = self._rod.loads()
        self._tip_point = self._rod.node(robot.length)[1]
        self._linear = Linearisation(self._rod)

    def loads(self, tensions: ArrayLike | None, tip_force: ArrayLike = ZERO) -> Loads:
        """Return the kernels' loads.

        Args:
            tensions: [N], shape (n,); none: all slack. tip_force: world frame [N], shape (3,).

        Raises:
            ParameterError: not finite, of another shape, or a negative tension.
        """
        pulls = np.zeros(len(self.robot.tendons)) if tensions is None else np.array(tensions, dtype=np.float64)
        pushed = np.asarray(tip_force, dtype=np.float64)
        if pulls.shape != self._free.tension.shape or not (pulls >= 0.0).all() or not np.isfinite(pulls).all():
            raise ParameterError(f"tensions must be {len(self._free.tension)} finite numbers, none negative")
        if pushed.shape != (3,) or not np.isfinite(pushed).all():
            raise ParameterError("tip_force must be three finite numbers")
        force = self._free.force.copy()
        force[self._tip_point] += pushed
        return self._free._replace(tension=pulls, force=force)

    def solve_static(
        self, tensions: ArrayLike | None = None, *, tip_force: ArrayLike = ZERO, start: GeneralState | None = None
    ) -> GeneralState:
        """Find a stable equilibrium, downhill from `start` or the reference shape; see `ModelRod`.

        Raises:
            ParameterError: see `loads`.
            ConvergenceError: none was found.
        """
        loads = self.loads(tensions, tip_force)
        found = self._rod.solve_static(loads, None if start is None else start.strain)
        position = self._rod.tip(found)[0]
        return GeneralState(found, loads.tension, np.array(tip_force, dtype=np.float64), position, np.zeros(3))

    def step(
        self, state: GeneralState, tensions: ArrayLike | None = None, *, tip_force: ArrayLike = ZERO
    ) -> GeneralState:
        """Compute the state one time step later, under loads that are held over it; see `ModelRod`.

        Raises:
            ParameterError: see `loads`.
            ConvergenceError: not a finite state.
        """
        loads = self.loads(tensions, tip_force)
        return self._after(state, self._rod.step(state.strain, loads), loads.tension, tip_force)

    def _after(self, before: GeneralState, strain: StrainState, tensions: Array, tip_force: ArrayLike) -> GeneralState:
        position = self._rod.tip(strain)[0]
        velocity = (position - before.position) / self.time_step
        return GeneralState(strain, tensions, np.array(tip_force, dtype=np.float64), position, velocity)

    def tip(self, state: GeneralState) -> Tip:
        """Return the tip, with a_c and b_c of the coming step; zeros where that has no solution: laws hold then."""
        acceleration, gain, h = np.zeros(3), np.zeros((3, len(state.tensions))), self.time_step
        with suppress(ConvergenceError):  # the step itself will say so
            step = self._ahead(state, state.tensions, state.tip_force)
            acceleration = ((self._rod.tip(step.state)[0] - state.position) / h - state.velocity) / h
            gain = step.position / h**2
        rotation = self._rod.tip(state.strain)[1]
        return Tip(state.position.copy(), rotation, state.velocity.copy(), acceleration, gain, state.tensions)

    def displacements(self, state: GeneralState, *, elastic: bool = False) -> Array:
        """Return the tendons' displacements [m], shape (n,); `elastic`: with the tendons' own stretch."""
        shortening = self._rod.displacements(state.strain)
        if not elastic:
            return shortening
        return shortening + stretches(self._rod.layout, state.strain.pulls, state.tensions, self.tendon_stiffness)

    def end_tensions(self, state: GeneralState) -> Array:
        """Return the tensions where the tendons are fixed to the robot [N], shape (n,); less or more by friction."""
        ends = state.tensions.copy()
        for index, tendon in enumerate(self.robot.tendons):
            if tendon.friction > 0.0:
                ends[index] = tension_along(self._rod, state.strain, index)[1][-1]
        return ends

    def predict(self, state: GeneralState, tensions: Array, inputs: Array, tip_force: Array) -> TipPrediction:
        """Predict the tip after the coming step; see `ModelRod`. It is the step itself, with its derivatives.

        Raises:
            ConvergenceError: not a finite state.
        """
        step = self._ahead(state, tensions, tip_force)
        position, rotation = self._rod.tip(step.state)
        direction = rotation[:, 2]
        turned = np.cross((step.rotation @ inputs.T).T, direction).T
        velocity = (position - state.position) / self.time_step
        return TipPrediction(position, velocity, direction, step.position @ inputs.T, turned)

    def velocity_jacobian(self, state: GeneralState, tendon: int) -> Array:
        """Return the derivative of the tip's velocity over the coming step by a tension [m/s/N], shape (3,)."""
        return np.asarray(self.tip(state).input_gain[:, tendon] * self.time_step)

    def _ahead(self, state: GeneralState, tensions: Array, tip_force: Array) -> InputSensitivity:
        return self._linear.inputs(state.strain, self.loads(tensions, tip_force))

    def node_positions(self, state: GeneralState) -> Array:
        """Return points of the backbone with equal parts of the compliance between them [m], shape (points, 3)."""
        points = np.empty((ARM_POINTS, 12))[:, :3]  # strided as the shooting rod's, for which the kernel is compiled
        points[:] = _interpolated(self._arm, self._shape(state))
        return points

    def curve(self, state: GeneralState, points: int = 50) -> Array:
        """Return evenly spaced points of the backbone, for display [m], shape (points, 3)."""
        return _interpolated(self._hermite(np.linspace(0.0, self._nodes[-1], points)), self._shape(state))

    def tendon_paths(self, state: GeneralState, points: int = 10) -> list[Array]:
        """Return points of each tendon, for display, world frame [m], shapes (k, 3): at most `points` of the nodes."""
        shape = self._shape(state)
        rotations = shape.rotation.reshape(-1, 3, 3)
        paths = []
        for tendon, holes in zip(self.robot.tendons, self._holes, strict=True):
            last = int(np.searchsorted(self._nodes, tendon.end * (1.0 + 1e-9), side="right")) - 1
            kept = np.unique(np.linspace(0, last, min(points, last + 1)).round().astype(np.intp))
            local = np.array([(*holes[k], 0.0) for k in kept])
            paths.append(shape.position[kept] + np.einsum("kij,kj->ki", rotations[kept], local))
        return paths

    def _shape(self, state: GeneralState) -> Shape:
        """Shape in memory of its own: what is for display may run beside a step."""
        shape = empty_shape(self._rod.layout)
        find_shape(self._rod.layout, state.strain.strain, shape)
        return shape

    def _hermite(self, at: Array) -> tuple[Array, Array]:
        """Weights of the nodes' positions, and of their tangents [m], at arc lengths [m]; shape (len(at), K + 1)."""
        right = np.clip(np.searchsorted(self._nodes, at), 1, len(self._nodes) - 1)
        left, rows = right - 1, np.arange(len(at))
        step = self._nodes[right] - self._nodes[left]
        t = (at - self._nodes[left]) / step
        places, tangents = np.zeros((2, len(at), len(self._nodes)))
        places[rows, right] = t * t * (3.0 - 2.0 * t)
        places[rows, left] = 1.0 - places[rows, right]
        tangents[rows, left] = step * t * (1.0 - t) ** 2
        tangents[rows, right] = step * t * t * (t - 1.0)
        return places, tangents


def _interpolated(weights: tuple[Array, Array], shape: Shape) -> Array:
    """Points between the nodes, by a cubic through their positions along their directions [m], shape (points, 3)."""
    return np.asarray(weights[0] @ shape.position + weights[1] @ shape.rotation[:, 2::3])
