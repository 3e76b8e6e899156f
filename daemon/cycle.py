"""One cycle of the controller: a pure function of setup, state and inputs. No clock, no I/O, no randomness.

The same `step` runs live and in lockstep with the simulator; run on recorded inputs it gives the recorded outputs.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.actuation import attainable, follow, lead, limit_displacement, limit_tension, share
from tendond.daemon.admission import admit
from tendond.daemon.laws.law import Decision, Observation
from tendond.daemon.modes import ACTIVE, Answer, advance_mode, enter, handle_request
from tendond.daemon.reference import PLANES
from tendond.daemon.state import CycleSetup, CycleState
from tendond.model.errors import ConvergenceError
from tendond.model.observer import ObserverState, observe
from tendond.model.rotation import quaternion
from tendond.model.tip import Tip
from tendond.schemas.base import Vector3
from tendond.schemas.messages import Mode, TendonCommand
from tendond.schemas.record import (
    CycleInputs,
    CycleRecord,
    ModelState,
    ObserverEstimate,
    ReferencePoint,
    TipEstimate,
)

Array = NDArray[np.float64]

YIELD = 0.4
"""Part per cycle by which a reference that may yield to loads follows the tip along the straight rod."""

FARTHEST = 0.08
"""Of the rod's length, that it yields at most: the other shape with the same x must not draw it over."""

ARRIVED = 0.1
"""Of the target, within which the tip has arrived for that."""

SLACK = 1e-3
"""[N] A lagging tendon that is told to be slack counts as slack below this."""


def step(setup: CycleSetup, state: CycleState, inputs: CycleInputs) -> tuple[CycleState, TendonCommand, CycleRecord]:
    """One cycle.

    Args:
        setup: of the controller.
        state: after the last cycle; it stays as it is.
        inputs: what has arrived since.

    Returns:
        The new state, the command to publish, and the record of it all.
    """
    tick, config = state.tick, setup.config
    admission = admit(setup, state, inputs)
    state = admission.state
    if state.mode is Mode.STARTING:
        state = enter(state, Mode.IDLE, "started")
    answer = Answer(False, "")
    if inputs.request is not None:
        state, answer = handle_request(setup, state, inputs.request)
    state = advance_mode(setup, state)

    tip = setup.rod.tip(state.rod)
    measured = None if state.pose is None else np.array(state.pose.position)
    fresh = measured if admission.fresh else None
    state = replace(state, observer=observe(setup.observer, state.observer, setup.rod, state.rod, tip.position, fresh))
    since = tick - state.since if state.mode is Mode.TRACKING else 0
    elapsed = since * config.loop.period
    reference = setup.reference.at(elapsed, state.slip)

    estimate, decision = None, None
    if state.mode is Mode.TRACKING:
        estimate = _estimate(setup, state, tip, fresh)
        if estimate is not None:
            decision = setup.law.decide(setup.law_parameters, _observation(setup, state, tip, estimate, reference))
    wanted = state.tension if decision is None else decision.tension
    overbent = None
    if decision is not None and config.control.feedback == "observer":
        overbent = setup.reference.overbent(tip.rotation[:, 2])
    if overbent is not None:  # an impact has thrown the arm over: back to where the law holds
        wanted = share(len(wanted), config.control.agonist, config.control.antagonist, overbent, 0.0)
    if state.mode is Mode.PRETENSION:
        wanted = _pretension(setup, state)
    command, met_tension = limit_tension(
        config.limits, config.loop.period, lead(wanted, state.tension, setup.lagging), state.commanded
    )
    if state.mode not in ACTIVE:
        command = np.maximum(state.commanded - config.limits.release_rate * config.loop.period, 0.0)

    wound = _wind(setup, state, command)
    if wound.met and state.mode in ACTIVE:  # what cannot be wound is not pulled
        held = _wind(setup, state, state.tension)
        part = attainable(held.asked, wound.asked, wound.command)
        met_displacement = wound.met
        wound = held if part == 0.0 else _wind(setup, state, state.tension + part * (command - state.tension))
        wound = replace(wound, met=met_displacement)
    state = wound.state
    met = met_tension + wound.met if state.mode in ACTIVE else ()
    command, displacement = state.commanded, wound.command
    if not (np.all(np.isfinite(command)) and np.all(np.isfinite(displacement))):
        state = enter(state, Mode.FAULT, "the command was not finite")
        zero = np.zeros_like(command)
        command, displacement = zero, zero
        state = replace(state, commanded=zero, tension=zero, wound=zero)
    state = replace(state, displacement=displacement, lagging=bool(wound.met) and state.mode not in ACTIVE)
    armed = state.mode in (*ACTIVE, Mode.RELEASING) or (
        state.mode is Mode.FAULT and (bool(np.any(command > 0.0)) or state.lagging)
    )
    message = TendonCommand(
        seq=tick,
        stamp_ns=0,
        pose_seq=None if state.pose is None else state.pose.seq,
        displacement=_numbers(displacement),
        tension=_numbers(command),
        armed=armed,
    )
    model_tip = setup.rod.tip(state.rod)
    record = CycleRecord(
        tick=tick,
        time=tick * config.loop.period,
        mode=state.mode,
        reason=state.reason,
        reply=answer.text,
        accepted=answer.accepted,
        inputs=inputs,
        rejected=admission.rejected,
        pose_age=state.pose_age,
        measured=None if state.pose is None else state.pose.position,
        reference=reference,
        observer=_observer_estimate(state.observer),
        estimate=estimate,
        terms={} if decision is None else decision.terms,
        wanted=_wanted(decision),
        tension=_numbers(state.tension),
        limited=met,
        model=ModelState(
            position=_vector(model_tip.position),
            orientation=quaternion(model_tip.rotation),
            residual=state.rod.residual,
            marches=state.rod.marches,
            error=wound.error,
        ),
        command=message,
    )
    slip = _slip(setup, state, elapsed, None if met else estimate, reference)
    runs = replace(state.runs, limited=state.runs.limited + 1 if met else 0)
    return replace(state, tick=tick + 1, runs=runs, slip=slip), message, record


def _estimate(setup: CycleSetup, state: CycleState, tip: Tip, fresh: Array | None) -> TipEstimate | None:
    """What the law is fed; none when there is nothing fresh to feed it, and the command is held."""
    if setup.config.control.feedback == "observer":
        position, velocity = tip.position + state.observer.offset, tip.velocity
    elif fresh is not None:
        earlier = fresh if state.earlier is None else state.earlier
        position = fresh
        velocity = (fresh - earlier) / (state.interval * setup.config.loop.period)
    else:
        return None
    return TipEstimate(position=_vector(position), velocity=_vector(velocity), acceleration=_vector(tip.acceleration))


def _observation(
    setup: CycleSetup, state: CycleState, tip: Tip, estimate: TipEstimate, reference: ReferencePoint
) -> Observation:
    control = setup.config.control
    return Observation(
        position=np.array(estimate.position),
        velocity=np.array(estimate.velocity),
        acceleration=tip.acceleration,
        input_gain=tip.input_gain,
        tension=state.tension,
        target=np.array(reference.position),
        target_velocity=np.array(reference.velocity),
        target_acceleration=np.array(reference.acceleration),
        axes=PLANES[control.plane],
        agonist=control.agonist,
        antagonist=control.antagonist,
        input_gain_min=setup.config.limits.input_gain_min,
        pair_tension=setup.config.pretension.antagonist,
    )


def _slip(
    setup: CycleSetup, state: CycleState, elapsed: float, estimate: TipEstimate | None, reference: ReferencePoint
) -> float:
    """How far the reference has yielded along the straight rod [m]: under a load the same x is at another z.

    It yields where the tip has arrived and no limit holds it back.
    """
    if state.mode is not Mode.TRACKING:
        return 0.0
    if estimate is None or not setup.reference.yields or elapsed < setup.reference.arrival:
        return state.slip
    across, along = setup.reference.curve.axes
    if abs(estimate.position[across] - reference.position[across]) > ARRIVED * abs(reference.position[across]):
        return state.slip
    slip = state.slip + YIELD * (estimate.position[along] - reference.position[along])
    most = FARTHEST * setup.config.rod.length
    return min(most, max(-most, slip))


def _pretension(setup: CycleSetup, state: CycleState) -> Array:
    """Tensions on their way to the pretension [N], shape (n,)."""
    section, control = setup.config.pretension, setup.config.control
    elapsed = (state.tick - state.since + 1) * setup.config.loop.period
    part = min(1.0, elapsed / max(section.duration, 1e-9))
    return part * share(len(state.tension), control.agonist, control.antagonist, section.tension, section.antagonist)


@dataclass(frozen=True)
class _Wound:
    """state: after the model's step; asked: displacements before limits [m]; command: within them; met: which."""

    state: CycleState
    asked: Array
    command: Array
    met: tuple[str, ...]
    error: str


def _wind(setup: CycleSetup, state: CycleState, command: Array) -> _Wound:
    """The model one step on, under the tension that follows from `command` [N], and what that takes to wind.

    The displacement follows from the model's shape. Without one, it is held while the arm is active, and let out in
    proportion to the tension while that is released.
    """
    config = setup.config
    tension = follow(command, state.tension, setup.lagging)
    tension = np.where((command == 0.0) & (tension < SLACK), 0.0, tension)
    after, error = _advance_model(setup, state, tension)
    if error:
        total = float(np.sum(state.tension))
        left = 1.0 if state.mode in ACTIVE else float(np.sum(tension)) / total if total > 0.0 else 0.0
        wanted = np.where(state.wound > 0.0, left * state.wound, state.wound)
    else:
        wanted = setup.rod.displacements(after.rod, elastic=config.rod.tendon_stiffness is not None)
        wanted = np.where(tension > 0.0, wanted, wanted - config.limits.slack)
    asked = lead(wanted, state.wound, setup.lagging)
    displacement, met = limit_displacement(config.limits, config.loop.period, asked, state.displacement)
    after = replace(after, tension=tension, commanded=command, wound=follow(displacement, state.wound, setup.lagging))
    return _Wound(after, asked, displacement, met, error)


def _advance_model(setup: CycleSetup, state: CycleState, tension: Array) -> tuple[CycleState, str]:
    """The model one step on; where that has no solution, without the observer's pull; else it stays where it is."""
    observer, error = state.observer, ""
    for force in (observer.tip_force, observer.force):
        try:
            rod = setup.rod.step(state.rod, tension, tip_force=force)
            return replace(state, rod=rod, runs=replace(state.runs, solver_failures=0)), ""
        except ConvergenceError as failure:
            error = str(failure)
    runs = replace(state.runs, solver_failures=state.runs.solver_failures + 1)
    return replace(state, runs=runs), error


def _observer_estimate(state: ObserverState) -> ObserverEstimate:
    return ObserverEstimate(
        innovation=_vector(state.innovation),
        force=_vector(state.force),
        pull=_vector(state.pull),
        offset=_vector(state.offset),
    )


def _wanted(decision: Decision | None) -> tuple[float, ...] | None:
    if decision is None or not np.all(np.isfinite(decision.tension)):
        return None
    return _numbers(decision.tension)


def _numbers(values: Array) -> tuple[float, ...]:
    return tuple(values.tolist())


def _vector(values: Array) -> Vector3:
    x, y, z = values.tolist()
    return x, y, z
