"""The MuJoCo plant as a rod of the simulator: steps of the plant's period, states that may be gone back to."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import eigvals
from scipy.spatial.transform import Rotation, Slerp

from tendond.drivers.mujoco.chain import Chain
from tendond.drivers.mujoco.robot import DivergedError, MujocoRobot
from tendond.drivers.simulator.mujoco_chain import chain_of
from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.rod.loads import ZERO
from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.tip import Tip
from tendond.model.strain.describe.configured import robot_from_section
from tendond.schemas.config.simulator import SimulatorSection

Array = NDArray[np.float64]

STEP_MAX = 1e-3
STEP_MIN = 2e-5
"""Bounds of the integrator's step [s]; at the smaller one a second of the plant takes several of the processor's."""

REST_SPEED = 1e-6
"""Rate of the joints below which a plant at rest is at rest [rad/s]."""


@dataclass(frozen=True)
class MujocoState:
    """State of the plant, and what it is observed by.

    Attributes:
        joints, rates: MuJoCo's qpos and qvel.
        tensions: of the tendons [N], shape (n,). shortening: of their paths, from straight [m], shape (n,).
        position, velocity, acceleration: of the tip [m, m/s, m/s^2], shape (3,); the acceleration is the mean over the
            last step. rotation: body to world, shape (3, 3). rate: of the tip, body frame [rad/s], shape (3,).
        points: of base, joints and tip [m], shape (links + 2, 3). rotations: of the links, shape (links, 3, 3).
    """

    joints: Array
    rates: Array
    tensions: Array
    shortening: Array
    position: Array
    velocity: Array
    acceleration: Array
    rotation: Array
    rate: Array
    points: Array
    rotations: Array


class MujocoRod:
    """A MuJoCo plant behind the interface `PlantRod`.

    Args:
        section: [simulator]. time_step: between two states [s].

    Raises:
        ParameterError: a robot that it cannot be, see `chain_of`; or too lightly damped for an explicit integrator.
    """

    def __init__(self, section: SimulatorSection, time_step: float) -> None:
        if section.servo.friction > 0.0:
            raise ParameterError(
                "simulator.servo.friction: the MuJoCo plant's tendons do not rub: set it to 0, or leave --plant out"
            )
        self.time_step = time_step
        robot = robot_from_section(section.rod)
        substep = stable_step(MujocoRobot(chain_of(robot)), by_winch=section.drive == "displacement")
        self._robot = MujocoRobot(chain_of(robot, time_step / math.ceil(time_step / substep - 1e-9)))
        self.parameters = RodParameters(**section.rod.parameters())
        self.tendon_stiffness = np.array([one.stiffness for one in self._robot.chain.tendons])
        chain = self._robot.chain
        self._centres = np.array([chain.begin(i) + 0.5 * chain.reach(i) for i in range(len(chain.links))])
        self._spread = np.zeros(len(chain.links))
        self._current: MujocoState | None = None

    @property
    def chain(self) -> Chain:
        """The plant's description."""
        return self._robot.chain

    def frequencies(self) -> Array:
        """Return the natural frequencies of the straight, weightless, undamped plant, ascending [rad/s].

        Those of bending come in pairs, and those of torsion are not a round rod's.
        """
        stiffness = np.diag(self._robot.model.jnt_stiffness[self._robot.model.dof_jntid])
        straight = MujocoRobot(self._robot.chain)
        return np.asarray(np.sqrt(np.sort(eigvals(straight.inertance() @ stiffness).real)))

    def solve_static(
        self, tensions: ArrayLike | None = None, *, tip_force: ArrayLike = ZERO, start: MujocoState | None = None
    ) -> MujocoState:
        """Find the equilibrium at rest, by settling from a neighbouring one.

        Args:
            tensions: [N], shape (n,). tip_force: world frame [N], shape (3,). start: where to settle from.

        Raises:
            ConvergenceError: it does not come to rest.
        """
        if start is not None:
            self._go_to(start)
        self._robot.set_tension(self._given(tensions))
        self._robot.push(np.asarray(tip_force, dtype=np.float64))
        try:
            self._robot.settle(speed=REST_SPEED)
        except DivergedError as error:
            raise self._diverged() from error
        return self._observed(np.zeros(3))

    def step(
        self,
        state: MujocoState,
        tensions: ArrayLike | None = None,
        *,
        displacements: ArrayLike | None = None,
        tip_force: ArrayLike = ZERO,
        push: ArrayLike = ZERO,
    ) -> MujocoState:
        """Compute the state one time step later, under loads that are held over it.

        Args:
            state: of this plant. tensions: [N], shape (n,). displacements: instead, of the elastic tendons' ends [m].
            tip_force, push: world frame [N], shape (3,).

        Raises:
            ConvergenceError: the integrator has no solution.
        """
        if state is not self._current:
            self._go_to(state)
        if displacements is None:
            self._robot.set_tension(self._given(tensions))
        else:
            self._robot.set_displacement(self._given(displacements))
        self._robot.push(np.asarray(tip_force, dtype=np.float64))
        self._robot.push_links(self._spread[:, None] * np.asarray(push, dtype=np.float64))
        try:
            self._robot.advance(self.time_step)
        except DivergedError as error:
            raise self._diverged() from error
        return self._observed(state.velocity)

    def tip(self, state: MujocoState) -> Tip:
        """Return the tip; without input gain, which no plant is asked for."""
        gain = np.zeros((3, len(state.tensions)))
        return Tip(state.position, state.rotation, state.velocity, state.acceleration, gain, state.tensions)

    def tip_motion(self, state: MujocoState) -> tuple[Array, Array]:
        """Return angular rate of the tip, body frame [rad/s], and acceleration, base's frame [m/s^2], shape (3,)."""
        return state.rate, state.acceleration

    def displacements(self, state: MujocoState, *, elastic: bool = False) -> Array:
        """Return the tendons' displacements [m], shape (n,): of their paths, or of the stretched tendons' ends."""
        return state.shortening + state.tensions / self.tendon_stiffness if elastic else state.shortening.copy()

    def curve(self, state: MujocoState, points: int = 50) -> Array:
        """Return points of the backbone [m], shape (points, 3)."""
        return self._along(state, np.linspace(0.0, self.parameters.length, points))

    def spread_push(self, place: float, half_width: float = 0.05) -> None:
        """Spread the push of later steps over the links of a stretch, as a parabola; see `Rod.spread_push`.

        Args:
            place: of its middle, as a part of the length. half_width: likewise.
        """
        share = np.maximum(0.0, 1.0 - ((self._centres / self.parameters.length - place) / half_width) ** 2)
        if not share.any():
            share[np.argmin(np.abs(self._centres - place * self.parameters.length))] = 1.0
        self._spread = share / share.sum()

    def load_tip(self, mass: float, inertia: ArrayLike = ZERO) -> None:
        """Add a ball to the tip of later steps; 0 takes it off again.

        Args:
            mass: [kg]. inertia: diagonal, of which the first is taken [kg m^2].

        Raises:
            ParameterError: a negative or non-finite mass.
        """
        if not (math.isfinite(mass) and mass >= 0.0):
            raise ParameterError(f"tip: mass = {mass!r} must be finite and not negative")
        self._robot.attach(mass, float(np.asarray(inertia, dtype=np.float64)[0]))

    def cross_sections(self, state: MujocoState, at: Array) -> tuple[Array, Array, Array]:
        """Return positions, orientations and strains at arc lengths.

        Between the centres of two links the rod turns evenly; its curvature is that turn by their distance.

        Args:
            state: of this plant. at: [m], shape (places,).

        Returns:
            Positions [m], shape (places, 3); orientations, body to base, shape (places, 3, 3); u [1/m] and v [-], shape
            (places, 6).
        """
        stations = np.concatenate(([0.0], self._centres, [self.parameters.length]))
        rotations = np.concatenate((np.eye(3)[None], state.rotations, state.rotation[None]))
        turns = Rotation.from_matrix(rotations)
        between = (turns[:-1].inv() * turns[1:]).as_rotvec() / np.diff(stations)[:, None]
        between[-1] = between[-2]  # the last link is rigid to the tip
        middles = 0.5 * (stations[:-1] + stations[1:])
        curvature = np.array([np.interp(at, middles, between[:, axis]) for axis in range(3)]).T
        tangent = np.tile([0.0, 0.0, 1.0], (len(at), 1))
        return self._along(state, at), Slerp(stations, turns)(at).as_matrix(), np.hstack((curvature, tangent))

    def _along(self, state: MujocoState, at: Array) -> Array:
        """Return points of the chain at arc lengths [m], shape (places, 3)."""
        chain = self._robot.chain
        stations = [0.0, *(chain.begin(i) for i in range(len(chain.links))), chain.length]
        return np.array([np.interp(at, stations, state.points[:, axis]) for axis in range(3)]).T

    def _given(self, values: ArrayLike | None) -> Array:
        """Check tensions or displacements; none: zeros.

        Raises:
            ParameterError: of another shape, or not finite.
        """
        count = len(self.tendon_stiffness)
        found = np.zeros(count) if values is None else np.asarray(values, dtype=np.float64)
        if found.shape != (count,) or not np.isfinite(found).all():
            raise ParameterError(f"tensions and displacements must be {count} finite numbers")
        return found

    def _diverged(self) -> ConvergenceError:
        """Return the error of an integrator that has no solution any more; no state is the present one."""
        self._current = None
        time = float(self._robot.data.time)
        self._robot.data.warning.number[:] = 0
        return ConvergenceError("the MuJoCo plant has diverged", time, math.nan, 0)

    def _go_to(self, state: MujocoState) -> None:
        self._robot.place(state.joints, state.rates)

    def _observed(self, velocity_before: Array) -> MujocoState:
        robot, rate = self._robot, self._robot.rate
        found = MujocoState(
            joints=robot.data.qpos.copy(),
            rates=robot.data.qvel.copy(),
            tensions=robot.tension,
            shortening=robot.shortening,
            position=robot.position,
            velocity=rate[3:],
            acceleration=(rate[3:] - velocity_before) / self.time_step,
            rotation=robot.rotation,
            rate=robot.rotation.T @ rate[:3],
            points=robot.joints,
            rotations=robot.link_rotations,
        )
        self._current = found
        return found


def stable_step(robot: MujocoRobot, *, by_winch: bool) -> float:
    """Return the largest step [s], of `STEP_MAX` halved, of which twice as much is stable on the straight robot.

    The step of MuJoCo's implicitfast is (M + h D) v' = M v - h K q, q' = q + h v': damping implicit, springs and
    winches explicit.

    Args:
        robot: the plant, straight. by_winch: driven by displacement, so that taut tendons are springs too.

    Raises:
        ParameterError: that step is below `STEP_MIN`.
    """
    model = robot.model
    inertance, identity = robot.inertance(), np.eye(model.nv)
    stiffness, damping = np.diag(model.jnt_stiffness[model.dof_jntid]), np.diag(model.dof_damping)
    if by_winch:
        winches = np.array([one.stiffness for one in robot.chain.tendons])
        arms = robot.tendon_arms()
        stiffness = stiffness + arms.T @ (winches[:, None] * arms)
    step = STEP_MAX
    while True:
        h = 2.0 * step
        slowed = np.linalg.inv(identity + h * inertance @ damping)
        left = -h * slowed @ inertance @ stiffness
        one_step = np.block([[identity + h * left, h * slowed], [left, slowed]])
        if float(np.abs(eigvals(one_step)).max()) <= 1.0 + 1e-9:
            return step
        step *= 0.5
        if step < STEP_MIN:
            raise ParameterError(
                "rod.bending_damping: too light for the MuJoCo plant, whose step would be below"
                f" {1e6 * STEP_MIN:g} us: set simulator.solver = 'general', or leave --plant out"
            )
