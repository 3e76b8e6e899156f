"""The general rod as controller and simulator run it: any robot, any damping, behind the shooting rod's interface.

What a law knows of the tip is that of whole steps: with x the tip's position,

    v(k) = (x(k) - x(k-1)) / h,    (v(k+1) - v(k)) / h = a_c + b_c T,    b_c = dx(k+1)/dT / h^2

by the derivative of the discrete step (`Linearisation.inputs`). The paper's own b_c belongs to one cross-section of
a continuous rod; it vanishes where that is straight, and for tendons that end before the tip. This one is what a
tension does to the tip within a cycle, of any robot. v is the mean velocity over a step: that at its end alternates
from step to step, as no scheme that conserves energy damps modes which are faster than the step.
"""

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.rod.loads import ZERO
from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.prediction import TipPrediction
from tendond.model.rod.tip import Tip
from tendond.model.rods.backbone import Backbone, interpolated
from tendond.model.rods.equivalent import arm_stiffness, equivalent_rod
from tendond.model.rods.stations import BodyLoads, Stations
from tendond.model.rods.tip_load import TipLoad
from tendond.model.strain.derivatives.linearise import Linearisation
from tendond.model.strain.derivatives.results import InputSensitivity
from tendond.model.strain.friction.along import stretches, tension_along
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
        stiffness: factor on the robot's [-]. tip_mass: on the tip beside the robot's own [kg].
        body: loads along the body, if any.
    """

    strain: StrainState
    tensions: Array
    tip_force: Array
    position: Array
    velocity: Array
    stiffness: float = 1.0
    body: BodyLoads | None = None
    tip_mass: float = 0.0

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
        compliance: as given.
        strain_rod: the rod in strain coordinates. backbone: points and frames along it; stations: where forces may act.
        tendon_stiffness: of each tendon, the shooting rod's for those that are given none [N/m], shape (n,).
        tip_load: where a mass on the tip is that a state has beside the robot's own.

    Raises:
        ParameterError: a robot that cannot be, or without a tendon.
    """

    whole_steps = True

    def __init__(self, robot: Robot, time_step: float, compliance: float = 1.0) -> None:
        self.robot, self.time_step, self.compliance = robot, time_step, compliance
        self.strain_rod = StrainRod(robot, time_step)
        self.strain_rod.layout.stiffness[:] /= compliance
        self._stiffness, self._factor = self.strain_rod.layout.stiffness.copy(), 1.0
        self.tip_load = TipLoad(self.strain_rod)
        self.parameters: RodParameters = equivalent_rod(self.strain_rod)
        stiffness, share, places = arm_stiffness(robot)
        self.arm_stiffness = stiffness / compliance
        given = self.strain_rod.layout.tendon_stiffness
        self.tendon_stiffness = np.where(given > 0.0, given, RodParameters.tendon_stiffness)
        self.backbone, self.stations = Backbone(self.strain_rod), Stations(self.strain_rod)
        self._arm = self.backbone.weights(np.interp(np.linspace(0.0, 1.0, ARM_POINTS), share, places))
        self._free = self.strain_rod.loads()
        self._tip_point = self.strain_rod.node(robot.length)[1]
        self._linear = Linearisation(self.strain_rod)

    def loads(self, tensions: ArrayLike | None, tip_force: ArrayLike = ZERO, body: BodyLoads | None = None) -> Loads:
        """Return the kernels' loads.

        Args:
            tensions: [N], shape (n,); none: all slack. tip_force: world frame [N], shape (3,). body: along it.

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
        if body is None:
            return self._free._replace(tension=pulls, force=force)
        force[self.stations.points] += body.forces
        return self._free._replace(tension=pulls, force=force, moment=body.moments)

    def solve_static(
        self,
        tensions: ArrayLike | None = None,
        *,
        tip_force: ArrayLike = ZERO,
        start: GeneralState | None = None,
        body: BodyLoads | None = None,
    ) -> GeneralState:
        """Find a stable equilibrium, downhill from `start` or the reference shape; see `ModelRod` and `loads`.

        Raises:
            ParameterError: see `loads`.
            ConvergenceError: none was found.
        """
        loads = self.loads(tensions, tip_force, body)
        factor, mass = (1.0, 0.0) if start is None else (start.stiffness, start.tip_mass)
        self._scale(factor, mass)
        found = self.strain_rod.solve_static(loads, None if start is None else start.strain)
        position = self.strain_rod.tip(found)[0]
        force = np.array(tip_force, dtype=float)
        return GeneralState(found, loads.tension, force, position, np.zeros(3), factor, body, mass)

    def step(
        self, state: GeneralState, tensions: ArrayLike | None = None, *, tip_force: ArrayLike = ZERO
    ) -> GeneralState:
        """Compute the state one time step later, under loads that are held over it; see `ModelRod`.

        Raises:
            ParameterError: see `loads`.
            ConvergenceError: not a finite state.
        """
        return self._stepped(state, self.loads(tensions, tip_force), tip_force)

    def step_bent(self, state: GeneralState, tensions: Array, tip_force: Array, body: BodyLoads) -> GeneralState:
        """Compute the state one time step later, with loads along the body; see `step` and `loads`."""
        return replace(self._stepped(state, self.loads(tensions, tip_force, body), tip_force), body=body)

    def _stepped(self, state: GeneralState, loads: Loads, tip_force: ArrayLike) -> GeneralState:
        self.use(state)
        return self._after(state, self.strain_rod.step(state.strain, loads), loads.tension, tip_force)

    def _after(self, before: GeneralState, strain: StrainState, tensions: Array, tip_force: ArrayLike) -> GeneralState:
        position = self.strain_rod.tip(strain)[0]
        velocity = (position - before.position) / self.time_step
        force = np.array(tip_force, dtype=float)
        return GeneralState(strain, tensions, force, position, velocity, before.stiffness, tip_mass=before.tip_mass)

    def moved(
        self, state: GeneralState, strain: Array, rate: Array, stiffness: float, tip_mass: float = 0.0
    ) -> GeneralState:
        """Return a state that is moved, as an estimator moves it.

        Args:
            state: the state. strain: added to its strains, shape (n,). rate: to their rates [1/s], shape (n,).
            stiffness: its new factor on the robot's stiffness [-]. tip_mass: its new mass on the tip [kg].
        """
        before = state.strain
        earlier = None if before.earlier is None else (before.earlier[0] + rate, before.earlier[1] + rate)
        after = replace(before, strain=before.strain + strain, rate=before.rate + rate, earlier=earlier)
        velocity = state.velocity + self.strain_rod.tip_jacobian(after) @ rate
        position = self.strain_rod.tip(after)[0]
        return replace(
            state, strain=after, position=position, velocity=velocity, stiffness=stiffness, tip_mass=tip_mass
        )

    def use(self, state: GeneralState) -> None:
        """Let the kernels take the stiffness and the mass of a state."""
        self._scale(state.stiffness, state.tip_mass)

    def _scale(self, factor: float, mass: float) -> None:
        if factor != self._factor:
            self.strain_rod.layout.stiffness[:] = factor * self._stiffness
            self._factor = factor
        self.tip_load.put(mass)

    def tip(self, state: GeneralState) -> Tip:
        """Return the tip, with a_c and b_c of the coming step; zeros where that has no solution: laws hold then."""
        acceleration, gain, h = np.zeros(3), np.zeros((3, len(state.tensions))), self.time_step
        with suppress(ConvergenceError):  # the step itself will say so
            step = self._ahead(state, state.tensions, state.tip_force)
            acceleration = ((self.strain_rod.tip(step.state)[0] - state.position) / h - state.velocity) / h
            gain = step.position / h**2
        rotation = self.strain_rod.tip(state.strain)[1]
        return Tip(state.position.copy(), rotation, state.velocity.copy(), acceleration, gain, state.tensions)

    def displacements(self, state: GeneralState, *, elastic: bool = False) -> Array:
        """Return the tendons' displacements [m], shape (n,); `elastic`: with the tendons' own stretch."""
        shortening = self.strain_rod.displacements(state.strain)
        if not elastic:
            return shortening
        return shortening + stretches(self.strain_rod.layout, state.strain.pulls, state.tensions, self.tendon_stiffness)

    def end_tensions(self, state: GeneralState) -> Array:
        """Return the tensions where the tendons are fixed to the robot [N], shape (n,); less or more by friction."""
        ends = state.tensions.copy()
        for index, tendon in enumerate(self.robot.tendons):
            if tendon.friction > 0.0:
                ends[index] = tension_along(self.strain_rod, state.strain, index)[1][-1]
        return ends

    def predict(self, state: GeneralState, tensions: Array, inputs: Array, tip_force: Array) -> TipPrediction:
        """Predict the tip after the coming step; see `ModelRod`. It is the step itself, with its derivatives.

        Raises:
            ConvergenceError: not a finite state.
        """
        step = self._ahead(state, tensions, tip_force)
        position, rotation = self.strain_rod.tip(step.state)
        direction = rotation[:, 2]
        turned = np.cross((step.rotation @ inputs.T).T, direction).T
        velocity = (position - state.position) / self.time_step
        return TipPrediction(position, velocity, direction, step.position @ inputs.T, turned)

    def velocity_jacobian(self, state: GeneralState, tendon: int) -> Array:
        """Return the derivative of the tip's velocity over the coming step by a tension [m/s/N], shape (3,)."""
        return np.asarray(self.tip(state).input_gain[:, tendon] * self.time_step)

    def _ahead(self, state: GeneralState, tensions: Array, tip_force: Array) -> InputSensitivity:
        self.use(state)
        return self._linear.inputs(state.strain, self.loads(tensions, tip_force, state.body))

    def node_positions(self, state: GeneralState) -> Array:
        """Return points of the backbone with equal parts of the compliance between them [m], shape (points, 3)."""
        points = np.empty((ARM_POINTS, 12))[:, :3]  # strided as the shooting rod's, for which the kernel is compiled
        points[:] = interpolated(self._arm, self.strain_rod.shape(state.strain))
        return points

    def curve(self, state: GeneralState, points: int = 50) -> Array:
        """Return evenly spaced points of the backbone, for display [m], shape (points, 3)."""
        return self.backbone.curve(state.strain, points)

    def tendon_paths(self, state: GeneralState, points: int = 10) -> list[Array]:
        """Return points of each tendon, for display, world frame [m], shapes (k, 3): at most `points` of the nodes."""
        return self.backbone.tendon_paths(state.strain, points)
