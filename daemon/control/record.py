"""The record of a cycle, from values that the cycle itself has made and bounded: they are not validated again."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.estimation.estimator import filter_estimate
from tendond.daemon.control.phases.modes import Reply
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState
from tendond.daemon.control.tasks.decision import Decision, LawTerms
from tendond.daemon.control.tasks.task import Situation
from tendond.model.numerics.rotation import quaternion
from tendond.model.rods.friction import end_tensions
from tendond.model.rods.selection import rubs
from tendond.schemas.base import Vector3
from tendond.schemas.messages import TendonCommand
from tendond.schemas.record import (
    RECORD_VERSION,
    CycleInputs,
    CycleRecord,
    Intervention,
    ModelState,
    ObserverEstimate,
    ReferencePoint,
    TipEstimate,
)


@dataclass(frozen=True, slots=True)
class Response:
    """Result of `cycle.respond`: the command, and everything else that belongs in the record.

    Attributes:
        state: state after the cycle; its `tick` is that of the next one.
        command: command to publish.
        inputs: inputs of the cycle; rejected: those that it did not use.
        reply: reply to the operator.
        reference: point of the reference.
        situation, decision: input and output of the law; none where none ran.
        limited: limits that the command met. safety: what the safety filter did, if anything.
        error: reason of the model's step without a solution.
    """

    state: CycleState
    command: TendonCommand
    inputs: CycleInputs
    rejected: tuple[str, ...]
    reply: Reply
    reference: ReferencePoint
    situation: Situation | None
    decision: Decision | None
    limited: tuple[str, ...]
    safety: Intervention | None
    error: str


def write_record(setup: CycleSetup, response: Response) -> CycleRecord:
    """Return the record of a cycle."""
    state, decision, situation = response.state, response.decision, response.situation
    tick, observer = state.tick - 1, state.observer
    wanted = None if decision is None else tuple(decision.tension.tolist())
    return CycleRecord.trusted(
        version=RECORD_VERSION,
        tick=tick,
        time=tick * setup.config.loop.period,
        mode=state.mode,
        reason=state.reason,
        reply=response.reply.text,
        accepted=response.reply.accepted,
        inputs=response.inputs,
        rejected=response.rejected,
        pose_age=state.pose_age,
        measured=None if state.pose is None else state.pose.position,
        reference=response.reference,
        observer=ObserverEstimate.trusted(
            innovation=_vector(observer.innovation),
            force=_vector(observer.force),
            pull=_vector(observer.pull),
            offset=_vector(observer.offset),
            residual=None if state.correction is None else _vector(state.correction.shift),
            filter=filter_estimate(setup.estimator, observer),
        ),
        estimate=None
        if situation is None
        else TipEstimate.trusted(
            position=_vector(situation.position),
            velocity=_vector(situation.velocity),
            acceleration=_vector(situation.tip.acceleration),
        ),
        terms={} if decision is None else _finite_terms(decision.terms),
        law_state={} if state.law_state is None else state.law_state.logged(),
        wanted=wanted if wanted is not None and all(map(math.isfinite, wanted)) else None,
        tension_estimate=tuple(state.tension_estimate.tolist()),
        tip_tension=tuple(end_tensions(setup.rod, state.rod).tolist()) if rubs(setup.config.rod) else (),
        law=state.selection.law_name,
        limited=response.limited,
        safety=response.safety,
        tuned=state.tuning.present,
        model=ModelState.trusted(
            position=_vector(state.tip.position),
            orientation=quaternion(state.tip.rotation),
            residual=state.rod.residual,
            marches=state.rod.marches,
            error=response.error,
        ),
        command=response.command,
    )


def _finite_terms(terms: LawTerms) -> dict[str, float | tuple[float, ...]]:
    """Return the finite terms: a law may divide by zero, and its command is then bounded, but not its terms."""
    return {
        name: value
        for name, value in vars(terms).items()
        if (all(map(math.isfinite, value)) if isinstance(value, tuple) else math.isfinite(value))
    }


def _vector(values: NDArray[np.float64]) -> Vector3:
    x, y, z = values.tolist()
    return x, y, z
