"""The task along a horizon: all tendons move the tip, by the model's own steps under a plan."""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from tendond.daemon.control.actuation import lag_factor_of
from tendond.daemon.control.pose.goals import counts_of, goal_at
from tendond.daemon.control.pose.pose import RADIAN, Aim
from tendond.daemon.control.predictive.body import BodyLimits
from tendond.daemon.control.predictive.horizon import Horizon
from tendond.daemon.control.predictive.limits import Applied, Bounds
from tendond.daemon.control.predictive.program import solver
from tendond.daemon.control.predictive.rollout import Predictor, Rollout
from tendond.daemon.control.reference.reference import Reference
from tendond.daemon.control.tasks.space import SPACE, tendon_allocation
from tendond.daemon.control.tasks.task import Decide, Ruling, Situation
from tendond.daemon.errors import LawError
from tendond.model.estimation.kalman.state import EstimatorState
from tendond.model.rod.parameters import RodParameters
from tendond.model.rods.general import GeneralRod, GeneralState
from tendond.model.rods.selection import model_rod
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig

Array = NDArray[np.float64]


class HorizonKeys(BaseModel):
    """Parameters of a law that are its task's: horizon: its length [s]. steps, knots: largest numbers of the model's
    steps, and of a plan's knots, between which the tensions are linear. avoid: plan round the constraints of [safety].
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    horizon: Annotated[float, Field(ge=0.02, le=2.0)] = 0.3
    steps: Annotated[int, Field(ge=2, le=60)] = 12
    knots: Annotated[int, Field(ge=2, le=60)] = 12
    avoid: bool = False


@dataclass(frozen=True)
class HorizonObservation:
    """Inputs of a law that plans along a horizon; world frame.

    Attributes:
        situation: state of knowledge. predictor: model of the robot along the horizon.
        aim: what of the tip's pose is prescribed. radian: distance that counts as much as a turn of 1 rad [m].
        place: of the tip now, in the aim's numbers: position [m], direction and first axis times `radian`, shape (r,).
        target: of the reference now, shape (r,); targets: at the end of each step, shape (N, r).
        beside: what is added to the model's positions for what is measured [m], shape (3,).
        bounds, applied: limits, and what the actuators are at. body: limits of the body, if there are any.
        length: unit of the error [m]. tension_unit: EI/(L r) [N].
        by_force: the observer moves the model by a force, which has yet to act.
    """

    situation: Situation
    predictor: Predictor
    aim: Aim
    radian: float
    place: Array
    target: Array
    targets: Array
    beside: Array
    bounds: Bounds
    applied: Applied
    length: float
    tension_unit: float
    by_force: bool
    body: BodyLimits | None = None

    @property
    def shift(self) -> Array:
        """Distance by which the observer corrects the model's tip [m], shape (3,), as the safety filter takes it."""
        observer = self.situation.observer
        if isinstance(observer, EstimatorState) or not self.by_force:
            return self.beside
        return self.beside + observer.innovation

    def roll(self, plan: Array) -> Rollout:
        """Run the model under a plan [N], shape (B, m).

        Raises:
            ConvergenceError: not a finite state.
        """
        model = self.situation.model
        assert isinstance(model, GeneralState)
        return self.predictor.roll(model, self.situation.observer, plan)

    def along(self, rollout: Rollout) -> tuple[Array, Array]:
        """Return the tip's places along the horizon, shape (N, r), and their derivatives, shape (N, r, B m)."""
        rows = _rows(self.aim, rollout.position + self.beside, rollout.direction, rollout.side, self.radian)
        by_plan = rollout.by_plan, rollout.direction_by_plan, rollout.side_by_plan
        columns = rollout.by_plan.shape[-1]
        turned = [one.swapaxes(1, 2).reshape(-1, 3) for one in by_plan]
        derivatives = _rows(self.aim, turned[0], turned[1], turned[2], self.radian)
        return rows, derivatives.reshape(len(rows), columns, -1).swapaxes(1, 2)


@dataclass(frozen=True)
class HorizonTask:
    """Follow a reference along a horizon.

    Attributes:
        reference: trajectory. aim: what of the tip's pose it prescribes.
        predictor: the model along the horizon. bounds: limits. body: limits of the body.
        length: of the robot [m]. tension_unit: EI/(L r) [N]. by_force: the observer moves the model by a force.
    """

    reference: Reference
    aim: Aim
    predictor: Predictor
    bounds: Bounds
    length: float
    tension_unit: float
    by_force: bool
    body: BodyLimits | None = None

    def pretension(self, fraction: float) -> Array:
        """Return the pretension [N], shape (n,), of which `fraction` is reached."""
        return np.full(self.predictor.tendons, fraction * self.bounds.tension_min)

    def rule(self, decide: Decide, situation: Situation) -> Ruling:
        """Run the law."""
        decision = decide(self.observe(situation))
        return Ruling(decision, decision.tension)

    def observe(self, situation: Situation) -> HorizonObservation:
        """Return the observation of a law with a horizon."""
        reference, aim, tip, elapsed = self.reference, self.aim, situation.tip, situation.elapsed
        times = np.concatenate(([0.0], self.predictor.horizon.ends)) + elapsed
        poses = [goal_at(reference, float(time), situation.offset).pose for time in times]
        places, directions = np.array([one.position for one in poses]), np.array([one.direction for one in poses])
        targets = _rows(aim, places, directions, np.array([one.rotation[:, 0] for one in poses]), self.radian)
        position, direction, side = situation.position[None], tip.rotation[None, :, 2], tip.rotation[None, :, 0]
        return HorizonObservation(
            situation=situation,
            predictor=self.predictor,
            aim=aim,
            radian=self.radian,
            place=_rows(aim, position, direction, side, self.radian)[0],
            target=targets[0],
            targets=targets[1:],
            beside=situation.position - tip.position,
            bounds=self.bounds,
            applied=Applied(situation.tension, situation.command, situation.displacement),
            length=self.length,
            tension_unit=self.tension_unit,
            by_force=self.by_force,
            body=self.body,
        )

    @property
    def radian(self) -> float:
        """Distance that counts as much as a turn of 1 rad [m]."""
        return RADIAN * self.length


def _rows(aim: Aim, position: Array, direction: Array, side: Array, radian: float) -> Array:
    """Return what counts of positions and axes, shapes (k, 3), in one measure [m], shape (k, r)."""
    if aim == "across":
        return position[:, :2]
    if aim == "position":
        return position
    if aim == "turned":
        return radian * direction
    if aim == "direction":
        return np.concatenate((position, radian * direction), axis=1)
    return np.concatenate((position, radian * direction, radian * side), axis=1)


class HorizonSpace:
    """Laws that plan along a horizon, on the general rod.

    Args:
        law: name of the law, whose table has the horizon's keys.
    """

    def __init__(self, law: str) -> None:
        self._law = law

    def follows(self, section: ReferenceSection) -> bool:
        """True if the reference can be followed: any."""
        return SPACE.follows(section)

    def tip_mass_max(self, config: RigConfig, rod: RodParameters) -> float:
        """Infinite: the plan knows the inertia of what is on the model's tip."""
        return math.inf

    def task(self, config: RigConfig, rod: RodParameters, reference: Reference) -> HorizonTask:
        """Make the task.

        Raises:
            LawError: the model is not the general rod, or the solver is not installed.
            ParameterError: the tendons do not surround the rod.
        """
        solver()
        tendon_allocation(config, rod)
        model = model_rod(config)
        if not isinstance(model, GeneralRod):
            raise LawError(
                f"control.law = '{self._law}' needs the general rod, and the model is the shooting rod: set "
                'control.solver = "general"'
            )
        given = config.control.laws.get(self._law, {})
        keys = HorizonKeys.model_validate({name: given[name] for name in HorizonKeys.model_fields if name in given})
        horizon = Horizon.of(keys.horizon, keys.steps, keys.knots, config.loop.period)
        limits = config.limits
        body = BodyLimits.of(config, model) if keys.avoid else None
        at = body.parts * model.robot.length if body is not None and body.surfaces.count else None
        arm = max(float(np.hypot(*place)) for place in rod.tendon_positions)
        return HorizonTask(
            reference=reference,
            aim=counts_of(reference),
            predictor=Predictor(model, horizon, at, elastic=config.rod.has_elastic_tendons),
            bounds=Bounds(
                tension_min=max(config.pretension.tension_min, limits.tension_min),
                tension_max=limits.tension_max,
                tension_rate=limits.tension_rate,
                displacement_min=limits.displacement_min,
                displacement_max=limits.displacement_max,
                displacement_rate=limits.displacement_rate,
                lag_factor=lag_factor_of(config.observer.lag, config.loop.period),
            ),
            length=rod.length,
            tension_unit=rod.bending_stiffness / (rod.length * arm),
            by_force=config.observer.kind == "force",
            body=body,
        )
