"""The record of a cycle, from values that the cycle itself has made and bounded: they are not validated again."""

import math

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.laws.law import Decision, LawTerms
from tendond.daemon.modes import Answer
from tendond.daemon.state import CycleState
from tendond.model.rotation import quaternion
from tendond.schemas.base import SCHEMA_VERSION, Vector3
from tendond.schemas.messages import TendonCommand
from tendond.schemas.record import (
    CycleInputs,
    CycleRecord,
    ModelState,
    ObserverEstimate,
    ReferencePoint,
    TipEstimate,
)


def write_record(
    state: CycleState,
    inputs: CycleInputs,
    rejected: tuple[str, ...],
    answer: Answer,
    period: float,
    reference: ReferencePoint,
    estimate: TipEstimate | None,
    decision: Decision | None,
    limited: tuple[str, ...],
    error: str,
    armed: bool,
) -> CycleRecord:
    """The record, with the command in it.

    Args:
        state: after the cycle; its `tick` is that of the next one.
        inputs: that the cycle saw; rejected: those that it did not use.
        answer: to the operator.
        period: of the cycle [s].
        reference, estimate, decision: of the law; the last two none where none ran.
        limited: limits that the command met.
        error: of the model's step.
        armed: whether the servos hold.
    """
    tick, pose, observer = state.tick - 1, state.pose, state.observer
    position = None if pose is None else pose.position
    command = TendonCommand.trusted(
        version=SCHEMA_VERSION,
        seq=tick,
        stamp_ns=0,
        pose_seq=None if pose is None else pose.seq,
        displacement=_numbers(state.displacement),
        tension=_numbers(state.commanded),
        armed=armed,
    )
    return CycleRecord.trusted(
        version=SCHEMA_VERSION,
        tick=tick,
        time=tick * period,
        mode=state.mode,
        reason=state.reason,
        reply=answer.text,
        accepted=answer.accepted,
        inputs=inputs,
        rejected=rejected,
        pose_age=state.pose_age,
        measured=position,
        reference=reference,
        observer=ObserverEstimate.trusted(
            innovation=_vector(observer.innovation),
            force=_vector(observer.force),
            pull=_vector(observer.pull),
            offset=_vector(observer.offset),
        ),
        estimate=estimate,
        terms={} if decision is None else _finite_terms(decision.terms),
        wanted=None if decision is None or not np.isfinite(decision.tension).all() else _numbers(decision.tension),
        tension=_numbers(state.tension),
        law=state.choice.law_name,
        limited=limited,
        model=ModelState.trusted(
            position=_vector(state.tip.position),
            orientation=quaternion(state.tip.rotation),
            residual=state.rod.residual,
            marches=state.rod.marches,
            error=error,
        ),
        command=command,
    )


def _finite_terms(terms: LawTerms) -> dict[str, float | tuple[float, ...]]:
    """Those that a log can hold: a law may divide by nothing, and its command is then bounded, but not its terms."""
    return {
        name: value
        for name, value in vars(terms).items()
        if (all(map(math.isfinite, value)) if isinstance(value, tuple) else math.isfinite(value))
    }


def _numbers(values: NDArray[np.float64]) -> tuple[float, ...]:
    return tuple(values.tolist())


def _vector(values: NDArray[np.float64]) -> Vector3:
    x, y, z = values.tolist()
    return x, y, z
