"""The task in space: all tendons move the tip, by the model's linearisation of the coming step; no further solves."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.pose.reference import PoseReference
from tendond.daemon.control.pose.task import pose_task
from tendond.daemon.control.reference.load_offset import moved_goal
from tendond.daemon.control.reference.reference import Reference
from tendond.daemon.control.tasks.observation import Prediction, SpatialObservation
from tendond.daemon.control.tasks.task import Decide, Ruling, Situation, Task
from tendond.model.errors import ConvergenceError
from tendond.model.rod.parameters import RodParameters
from tendond.model.rods.general import GeneralState
from tendond.model.rods.interface import ModelState
from tendond.model.rods.selection import solver_of
from tendond.model.tendons.allocation import Allocation
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.rod.swing import mass_within_cycle, swings

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SpatialTask:
    """Follow a reference with all tendons.

    Attributes:
        reference: trajectory in space or in the bending plane.
        allocation: map from bending moments to tensions; with scratch memory of its own.
        period: period of the cycle [s].
        tension_min: pretension of every tendon [N].
    """

    reference: Reference
    allocation: Allocation
    period: float
    tension_min: float

    def pretension(self, fraction: float) -> Array:
        """Return the pretension [N], shape (n,), of which `fraction` is reached."""
        return np.full(self.allocation.arms.shape[1], fraction * self.tension_min)

    def rule(self, decide: Decide, situation: Situation) -> Ruling:
        """Run the law."""
        decision = decide(self.observe(situation))
        return Ruling(decision, decision.tension)

    def observe(self, situation: Situation) -> SpatialObservation:
        """Return the observation of a law in space: the tip's position, or its direction where that is the aim."""
        tip, period, elapsed, offset = situation.tip, self.period, situation.elapsed, situation.offset
        target, target_velocity = np.array(situation.reference.position), np.array(situation.reference.velocity)
        position, velocity = situation.position, situation.velocity
        model, force = _weighed(situation)
        try:
            step = situation.rod.predict(model, situation.acting, self.allocation.shares, force)
        except ConvergenceError:  # the step itself will say so
            return SpatialObservation(position, velocity, target, target_velocity, situation.tension, period, None)
        then = self.reference.goal(elapsed + period)
        if self.reference.aim == "direction":
            position, velocity = tip.rotation[:, 2], (step.direction - tip.rotation[:, 2]) / period
            ahead, jacobian = step.direction, step.direction_jacobian
            target = self.reference.goal(elapsed).place
            target_velocity = (then.place - target) / period
        else:
            then = moved_goal(then, offset)
            beside = position - tip.position  # the tip's distance from the model's: of an observer of kind 'offset'
            ahead, jacobian = step.position + beside, step.position_jacobian
        prediction = Prediction(ahead, jacobian, then.place, then.jacobian, self.allocation)
        return SpatialObservation(position, velocity, target, target_velocity, situation.tension, period, prediction)


def _weighed(situation: Situation) -> tuple[ModelState, Array]:
    """Return the model's state and the force on its tip [N], shape (3,), for a law that moves the tip within a cycle.

    Of a mass that the filter has found there, it is given the weight alone: for the inertia of a heavy tip its agility
    does not suffice, and it would swing the arm (`swing.TIP_LOAD_MAX`).
    """
    model, force = situation.model, situation.observer.tip_force
    if not isinstance(model, GeneralState) or model.tip_mass <= 0.0:
        return model, force
    return replace(model, tip_mass=0.0), force + model.tip_mass * np.array(situation.rod.parameters.gravity)


class Space:
    """Laws that move the tip in space; they follow references in the bending plane as well."""

    def follows(self, section: ReferenceSection) -> bool:
        """True if the reference can be followed: any."""
        return True

    def tip_mass_max(self, config: RigConfig, rod: RodParameters) -> float:
        """Largest rod.tip_mass that the loop of such a law bears [kg]: infinite on the general rod, by its rests."""
        general = solver_of(config.rod, config.control.solver) == "general"
        return math.inf if general else tip_mass_within_cycle(config, rod)

    def task(self, config: RigConfig, rod: RodParameters, reference: Reference) -> Task:
        """Make the task: of poses for a reference of poses, and for a robot that swings.

        Raises:
            ParameterError: the tendons do not surround the rod.
        """
        if isinstance(reference, PoseReference) or by_rests(config, rod):
            return pose_task(config, reference)
        return SpatialTask(reference, tendon_allocation(config, rod), config.loop.period, config.pretension.tension_min)


def by_rests(config: RigConfig, rod: RodParameters) -> bool:
    """Return whether the law moves the arm along its rests: the general rod, where moving it at once makes it swing."""
    if config.control.rules == 1 or solver_of(config.rod, config.control.solver) == "shooting":
        return False
    return bool(swings(config.rod, config.loop.period)) or rod.tip_mass > tip_mass_within_cycle(config, rod)


def tip_mass_within_cycle(config: RigConfig, rod: RodParameters) -> float:
    """Return the largest mass on the tip for a law that moves it within a cycle [kg]."""
    arm = max(math.hypot(x, y) for x, y in rod.tendon_positions)
    mass = rod.mass_per_length * rod.length
    return mass_within_cycle(rod.bending_stiffness, rod.length, mass, arm, config.loop.period)


def tendon_allocation(config: RigConfig, rod: RodParameters) -> Allocation:
    """Return the allocation of a rod's tendons, within pretension and largest tension.

    Raises:
        ParameterError: the tendons do not surround the rod, or the bounds leave no room.
    """
    return Allocation(rod.tendon_positions, config.pretension.tension_min, config.limits.tension_max)


SPACE = Space()
