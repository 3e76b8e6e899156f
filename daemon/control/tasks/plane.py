"""The task in the bending plane: an agonist, and an antagonist if any, move the tip across the straight rod."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.actuation import share
from tendond.daemon.control.reference.planar import PLANES, PlanarReference
from tendond.daemon.control.reference.reference import Reference
from tendond.daemon.control.tasks.observation import PlanarObservation
from tendond.daemon.control.tasks.task import Decide, Ruling, Situation
from tendond.model.errors import ParameterError
from tendond.model.rod.parameters import RodParameters
from tendond.schemas.config.control import ControlSection
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PlanarTask:
    """Follow a reference in the bending plane.

    Attributes:
        reference: trajectory in the plane.
        control: [control] of the configuration.
        tendon_count: n.
        tension, pair_tension: pretension of the agonist's net, and of both tendons of the pair [N].
        input_gain_min: see `PlanarObservation`.
        period: period of the cycle [s].
    """

    reference: PlanarReference
    control: ControlSection
    tendon_count: int
    tension: float
    pair_tension: float
    input_gain_min: float
    period: float

    def pretension(self, fraction: float) -> Array:
        """Return the pretension [N], shape (n,), of which `fraction` is reached."""
        control = self.control
        return fraction * share(self.tendon_count, control.agonist, control.antagonist, self.tension, self.pair_tension)

    def rule(self, decide: Decide, situation: Situation) -> Ruling:
        """Run the law; where an impact has moved the arm past its target, hold the target's tension instead.

        There the inverse of b_c has the wrong sign, and the law would go on pulling. Only the observer knows the
        shape of the rod then.
        """
        decision = decide(self.observe(situation))
        if self.control.feedback != "observer":
            return Ruling(decision, decision.tension)
        hold = self.reference.past_target(situation.tip.rotation[:, 2])
        if hold is None:
            return Ruling(decision, decision.tension)
        control = self.control
        return Ruling(decision, share(len(decision.tension), control.agonist, control.antagonist, hold, 0.0))

    def observe(self, situation: Situation) -> PlanarObservation:
        """Return the observation of a law in the plane."""
        control, tip, reference = self.control, situation.tip, situation.reference
        whole_steps = control.sampled and situation.rod.whole_steps
        return PlanarObservation(
            position=situation.position,
            velocity=situation.velocity,
            acceleration=tip.acceleration,
            input_gain=tip.input_gain,
            velocity_jacobian=situation.rod.velocity_jacobian(situation.model, control.agonist)
            if control.sampled and not whole_steps
            else None,
            tension=situation.tension,
            target=np.array(reference.position),
            target_velocity=np.array(reference.velocity),
            target_acceleration=np.array(reference.acceleration),
            axes=PLANES[control.plane],
            agonist=control.agonist,
            antagonist=control.antagonist,
            input_gain_min=self.input_gain_min,
            pair_tension=self.pair_tension,
            period=self.period,
            whole_steps=whole_steps,
        )


class BendingPlane:
    """Laws that move the tip in the bending plane."""

    def follows(self, section: ReferenceSection) -> bool:
        """True if the reference lies in the bending plane."""
        return not section.in_space

    def tip_mass_max(self, config: RigConfig, rod: RodParameters) -> float:
        """Infinite: the loop bears any."""
        return math.inf

    def task(self, config: RigConfig, rod: RodParameters, reference: Reference) -> PlanarTask:
        """Make the task.

        Raises:
            ParameterError: the reference is in space.
        """
        if not isinstance(reference, PlanarReference):
            raise ParameterError("the reference is in space, where one of the bending plane is needed")
        return PlanarTask(
            reference=reference,
            control=config.control,
            tendon_count=rod.tendon_count,
            tension=config.pretension.tension,
            pair_tension=config.pretension.antagonist,
            input_gain_min=config.limits.input_gain_min,
            period=config.loop.period,
        )


BENDING_PLANE = BendingPlane()
