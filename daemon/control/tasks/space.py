"""The task in space: all tendons move the tip, by the model's linearisation of the coming step; no further solves."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.pose.reference import PoseReference
from tendond.daemon.control.pose.task import pose_task
from tendond.daemon.control.reference.load_offset import moved_goal
from tendond.daemon.control.reference.reference import Reference
from tendond.daemon.control.tasks.observation import Prediction, SpatialObservation
from tendond.daemon.control.tasks.task import Decide, Ruling, Situation, Task
from tendond.model.errors import ConvergenceError
from tendond.model.estimation.margin import EARTH
from tendond.model.rod.parameters import RodParameters
from tendond.model.tendons.allocation import Allocation
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig

Array = NDArray[np.float64]

TIP_LOAD_MAX = 0.2
"""Largest P L^2/EI of the model's own tip body: 12 g on the paper's robot. A law in space asks for a tip that is moved
within a cycle, and its agility does not suffice for a heavy one: it then swings the arm. From runs with plant = model
at 100 Hz: they settle at 0.22 to 0.25 and swing at 0.33 to 0.35, with E -30 %, as it is, and +50 %. On the general
rod the paper's robot settles with 12 g at targets 0.05 to 0.34 m across; with 20 g it whirls at those up to 0.15 m, and
settles at those from 0.2 m on. A law's agility is less beside the tensions of a robot that needs larger ones: with
tendons at half the distance it settles with 3 g, and swings with 4.2 g on the shooting rod, 12 g on either; so the
bound falls with the square of EI/(L r) beyond the paper's robot's. The tests hold both sides, of both rods."""

PERIODS_MIN = 15.0
"""Cycles in sqrt(rho A L^4/EI), below which the bound falls with the third power of their number: from the same runs at
50, 70, 100 and 250 Hz, which swing with 2, 10, 20 and 30 g and settle with none, 5, 15 and 25 g."""


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
        try:
            step = situation.rod.predict(
                situation.model, situation.acting, self.allocation.shares, situation.observer.tip_force
            )
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


class Space:
    """Laws that move the tip in space; they follow references in the bending plane as well."""

    def follows(self, section: ReferenceSection) -> bool:
        """True if the reference can be followed: any."""
        return True

    def tip_mass_max(self, config: RigConfig, rod: RodParameters) -> float:
        """Largest rod.tip_mass that the loop of such a law bears [kg]."""
        mass = TIP_LOAD_MAX * rod.bending_stiffness / (EARTH * rod.length**2)
        rod_time = math.sqrt(rod.mass_per_length * rod.length**4 / rod.bending_stiffness)
        rate, agility = rod_time / (PERIODS_MIN * config.loop.period), 1.0 / rod.tension_scale
        return mass * min(1.0, rate**3, agility**2)

    def task(self, config: RigConfig, rod: RodParameters, reference: Reference) -> Task:
        """Make the task: of poses for a reference of poses.

        Raises:
            ParameterError: the tendons do not surround the rod.
        """
        if isinstance(reference, PoseReference):
            return pose_task(config, reference)
        return SpatialTask(reference, tendon_allocation(config, rod), config.loop.period, config.pretension.tension_min)


def tendon_allocation(config: RigConfig, rod: RodParameters) -> Allocation:
    """Return the allocation of a rod's tendons, within pretension and largest tension.

    Raises:
        ParameterError: the tendons do not surround the rod, or the bounds leave no room.
    """
    return Allocation(rod.tendon_positions, config.pretension.tension_min, config.limits.tension_max)


SPACE = Space()
