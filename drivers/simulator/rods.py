"""Rods of the simulated plant: the shooting rod, or the general one for robots that shooting does not solve."""

from dataclasses import replace
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendond.drivers.simulator.strain_places import StrainPlaces
from tendond.model.errors import ParameterError
from tendond.model.rod.loads import ZERO
from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.tip import Tip
from tendond.model.rods.general import GeneralRod, GeneralState
from tendond.model.rods.selection import rod_from_section, rubs, solver_of
from tendond.model.strain.analysis.accuracy import tip_error
from tendond.model.strain.describe.configured import robot_from_section
from tendond.model.strain.friction.along import stretches
from tendond.model.strain.robot import Robot
from tendond.model.strain.stepping.scratch import Loads
from tendond.schemas.config.simulator import SimulatorSection

Array = NDArray[np.float64]

ACCURACY = 0.005
"""Estimated error of a simulated tip, as a part of the robot's length, beyond which it is reported."""

CHECK_EVERY = 5
"""Steps between two estimates of the error: one takes a third of a step."""


class PlantRod(Protocol):
    """A rod as the plant runs it, with states of its own; `model.rod.rod.Rod` is one."""

    time_step: float

    @property
    def parameters(self) -> RodParameters:
        """Parameters, or those of the uniform rod that stands for it."""

    @property
    def tendon_stiffness(self) -> float | Array:
        """Force per stretch [N/m], of all tendons or one each, shape (n,)."""

    def solve_static(self, tensions: ArrayLike | None = None, *, tip_force: ArrayLike = ZERO, start: Any = None) -> Any:
        """Find the equilibrium at rest, from a neighbouring one."""

    def step(
        self,
        state: Any,
        tensions: ArrayLike | None = None,
        *,
        displacements: ArrayLike | None = None,
        tip_force: ArrayLike = ZERO,
        push: ArrayLike = ZERO,
    ) -> Any:
        """Compute the state one time step later."""

    def tip(self, state: Any) -> Tip:
        """Return the tip."""

    def displacements(self, state: Any, *, elastic: bool = False) -> Array:
        """Return the tendons' displacements [m], shape (n,)."""

    def curve(self, state: Any, points: int = 50) -> Array:
        """Return points of the backbone [m], shape (points, 3)."""

    def spread_push(self, place: float, half_width: float = 0.05) -> None:
        """Spread later pushes over a stretch of the rod."""

    def load_tip(self, mass: float, inertia: ArrayLike = ZERO) -> None:
        """Add a body to the tip."""


PLANTS = ("shooting", "general", "mujoco")
"""Names of the plants, values of `simulator.solver`."""

PlantSolver = Literal["shooting", "general", "mujoco"]


def plant_solver(section: SimulatorSection) -> PlantSolver:
    """Return the solver of a simulated plant: `simulator.solver`, else the one that its robot and friction need."""
    if section.solver == "mujoco":
        return "mujoco"
    if section.solver is None and section.servo.friction > 0.0:
        return "general"
    return solver_of(section.rod, section.solver)


def plant_rod(section: SimulatorSection, time_step: float) -> PlantRod:
    """Return the rod of a simulated plant, by `plant_solver`.

    Args:
        section: [simulator].
        time_step: [s].

    Raises:
        ParameterError: a robot that cannot be, or that the named solver does not solve.
        ModuleNotFoundError: solver 'mujoco', and it is not installed.
    """
    if plant_solver(section) == "mujoco":
        from tendond.drivers.simulator.mujoco_rod import MujocoRod

        return MujocoRod(section, time_step)
    if plant_solver(section) == "general":
        return GeneralPlantRod(plant_robot(section), time_step)
    if section.servo.friction > 0.0 or rubs(section.rod):
        raise ParameterError(
            "simulator.solver = 'shooting': that rod has no friction of tendons: remove the key, or set"
            " simulator.servo.friction and that of the rod's tendons to 0"
        )
    return rod_from_section(section.rod, time_step)


def plant_robot(section: SimulatorSection) -> Robot:
    """Return a simulated plant's robot for the general rod, whose tendons without friction have that of the servos.

    Raises:
        ParameterError: a robot that cannot be.
    """
    robot, friction = robot_from_section(section.rod), section.servo.friction
    tendons = tuple(replace(one, friction=one.friction or friction) for one in robot.tendons)
    return replace(robot, tendons=tendons)


class GeneralPlantRod(GeneralRod):
    """The general rod as a plant's: also driven by displacement, pushed anywhere, with a weight on the tip.

    Args:
        robot: to simulate.
        time_step: [s].

    Attributes:
        error_max: of the tip, the largest estimate so far [m]; see `model.strain.analysis.accuracy`.

    Raises:
        ParameterError: a robot that cannot be.
    """

    def __init__(self, robot: Robot, time_step: float) -> None:
        super().__init__(robot, time_step)
        self.error_max = 0.0
        self._steps = 0
        layout = self.strain_rod.layout
        layout.tendon_stiffness[:] = self.tendon_stiffness  # the shooting rod's, for those that are given none
        self._own_mass = layout.mass.copy()
        self._push = np.zeros(len(layout.mass))
        self._rubbing = np.flatnonzero(layout.friction > 0.0)
        self._places: dict[bytes, StrainPlaces] = {}

    def step(
        self,
        state: GeneralState,
        tensions: ArrayLike | None = None,
        *,
        displacements: ArrayLike | None = None,
        mean: ArrayLike | None = None,
        tip_force: ArrayLike = ZERO,
        push: ArrayLike = ZERO,
    ) -> GeneralState:
        """Compute the state one time step later, under loads that are held over it.

        A step holds the mean of what drives a tendon, which is of second order. One with friction takes it at the
        step's end, as the tensions along it are those at the end.

        Args:
            state: of this rod. tensions: at the end of the step [N], shape (n,). displacements: instead, of the elastic
                tendons' ends [m]. mean: of either over the step; default: as at its end.
            tip_force, push: world frame [N], shape (3,).

        Raises:
            ConvergenceError: there is no solution.
        """
        given = tensions if displacements is None else displacements
        ends = np.zeros(len(self.tendon_stiffness)) if given is None else np.array(given, dtype=np.float64)
        held = ends.copy() if mean is None else np.array(mean, dtype=np.float64)
        held[self._rubbing] = ends[self._rubbing]
        loads: Loads = (
            self.strain_rod.loads(tension=held, tip_force=tip_force)
            if displacements is None
            else self.strain_rod.loads(displacement=held, tip_force=tip_force)
        )
        loads.force[:] += self._push[:, None] * np.asarray(push, dtype=np.float64)
        new = self.strain_rod.step(state.strain, loads)
        self._steps += 1
        if self._steps % CHECK_EVERY == 0:
            self.error_max = max(self.error_max, *tip_error(self.strain_rod, new))
        taut = ends
        if displacements is not None:
            taut = np.maximum(0.0, self.tendon_stiffness * (ends - self.strain_rod.displacements(new)))
            if new.pulls is not None:
                taut[self._rubbing] = new.pulls[:, 0]
        return self._after(state, new, taut, tip_force)

    def mean_tensions(self, state: GeneralState) -> Array:
        """Return the tensions of the tendons, means along those that rub [N], shape (n,)."""
        layout, tensions = self.strain_rod.layout, state.tensions.copy()
        stretched = stretches(layout, state.strain.pulls, tensions, self.tendon_stiffness)
        tensions[self._rubbing] = (stretched * self.tendon_stiffness)[self._rubbing]
        return tensions

    def tip(self, state: GeneralState) -> Tip:
        """Return the tip; without acceleration and input gain, which no plant asks for."""
        position, rotation = self.strain_rod.tip(state.strain)
        nothing = np.zeros(3)
        return Tip(
            position, rotation, self.strain_rod.tip_velocity(state.strain), nothing, np.zeros((3, 0)), state.tensions
        )

    def cross_sections(self, state: GeneralState, at: Array) -> tuple[Array, Array, Array]:
        """Return positions, orientations and strains at arc lengths [m]; see `StrainPlaces.find`."""
        places = self._places.get(key := at.tobytes())
        if places is None:
            places = self._places[key] = StrainPlaces(self.strain_rod, at)
        return places.find(state.strain)

    def spread_push(self, place: float, half_width: float = 0.05) -> None:
        """Spread the push of later steps over the mass points of a stretch, as a parabola; see `Rod.spread_push`.

        Where fewer than two lie there, over the two beside its middle, so that force and moment are those of the push.

        Args:
            place: of its middle, as a part of the length. half_width: likewise.
        """
        layout = self.strain_rod.layout
        at = np.concatenate(([0.0], np.cumsum(layout.step)))[layout.place] / self.parameters.length
        on_axis = ~layout.arm.any(axis=1)
        share = np.where(on_axis, np.maximum(0.0, 1.0 - ((at - place) / half_width) ** 2), 0.0)
        if np.count_nonzero(share) < 2:
            share = np.zeros(len(at))
            points = np.flatnonzero(on_axis)[np.argsort(at[on_axis])]
            share[points] = [np.interp(place, at[points], one) for one in np.eye(len(points))]
        self._push = share / share.sum()

    def load_tip(self, mass: float, inertia: ArrayLike = ZERO) -> None:
        """Add a mass to the tip of later steps [kg]; its own inertia is left out, as a ball's is small.

        Args:
            mass: [kg]; 0 takes it off again. inertia: not used.

        Raises:
            ParameterError: a negative or non-finite mass.
        """
        if not (np.isfinite(mass) and mass >= 0.0):
            raise ParameterError(f"tip: mass = {mass!r} must be finite and not negative")
        self.strain_rod.layout.mass[:] = self._own_mass
        self.strain_rod.layout.mass[self._tip_point] += mass
