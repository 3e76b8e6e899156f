"""One cycle of the controller: a pure function of setup, state and inputs. No clock, no I/O, no randomness.

The same `step` runs live and in lockstep with the simulator; run on recorded inputs it gives the recorded outputs.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.admission import admit
from tendond.daemon.laws.law import Decision, Observation
from tendond.daemon.limits import limit_displacement, limit_tension
from tendond.daemon.modes import ACTIVE, Answer, advance_mode, enter, handle_request
from tendond.daemon.reference import PLANES, reference_at
from tendond.daemon.state import CycleSetup, CycleState
from tendond.model.errors import ConvergenceError
from tendond.model.observer import observe
from tendond.model.rotation import quaternion
from tendond.model.tip import Tip
from tendond.schemas.base import Vector3
from tendond.schemas.messages import Mode, TendonCommand
from tendond.schemas.record import CycleInputs, CycleRecord, ModelState, ReferencePoint, TipEstimate

Array = NDArray[np.float64]


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
    observer = observe(state.observer, tip.position, measured if admission.fresh else None, config.observer.gain)
    state = replace(state, observer=observer)
    since = tick - state.since if state.mode is Mode.TRACKING else 0
    reference = reference_at(config.reference, config.control.plane, since * config.loop.period)

    estimate, decision = None, None
    if state.mode is Mode.TRACKING:
        estimate = _estimate(setup, state, tip, measured, admission.fresh)
        if estimate is not None:
            decision = setup.law.decide(setup.law_parameters, _observation(setup, state, tip, estimate, reference))
    wanted = state.tension if decision is None else decision.tension
    if state.mode is Mode.PRETENSION:
        wanted = _pretension(setup, state)
    tension, met_tension = limit_tension(config.limits, config.loop.period, wanted, state.tension)
    if state.mode not in ACTIVE:
        tension = np.maximum(state.tension - config.limits.release_rate * config.loop.period, 0.0)

    before = state
    state, model_error = _advance_model(setup, before, tension)
    displacement, met_displacement = _displacement(setup, state, tension, model_error)
    if met_displacement and state.mode in ACTIVE:  # what cannot be wound is not pulled: the tension stays where it was
        tension = before.tension
        state, model_error = _advance_model(setup, before, tension)
        displacement, _ = _displacement(setup, state, tension, model_error)
    met = met_tension + met_displacement if state.mode in ACTIVE else ()
    if not (np.all(np.isfinite(tension)) and np.all(np.isfinite(displacement))):
        state = enter(state, Mode.FAULT, "the command was not finite")
        tension, displacement = np.zeros_like(tension), np.zeros_like(displacement)
    state = replace(state, lagging=bool(met_displacement) and state.mode not in ACTIVE)
    armed = state.mode in (*ACTIVE, Mode.RELEASING) or (
        state.mode is Mode.FAULT and (bool(np.any(tension > 0.0)) or state.lagging)
    )
    command = TendonCommand(
        seq=tick,
        stamp_ns=0,
        pose_seq=None if state.pose is None else state.pose.seq,
        displacement=_numbers(displacement),
        tension=_numbers(tension),
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
        estimate=estimate,
        terms={} if decision is None else decision.terms,
        wanted=_wanted(decision),
        tension=_numbers(tension),
        limited=met,
        model=ModelState(
            position=_vector(model_tip.position),
            orientation=quaternion(model_tip.rotation),
            residual=state.rod.residual,
            marches=state.rod.marches,
            error=model_error,
        ),
        command=command,
    )
    runs = replace(state.runs, limited=state.runs.limited + 1 if met else 0)
    return replace(state, tick=tick + 1, tension=tension, displacement=displacement, runs=runs), command, record


def _estimate(
    setup: CycleSetup, state: CycleState, tip: Tip, measured: Array | None, fresh: bool
) -> TipEstimate | None:
    """What the law is fed; none when there is nothing fresh to feed it, and the command is held."""
    if setup.config.control.feedback == "observer":
        position, velocity = tip.position + state.observer.offset, tip.velocity
    elif fresh and measured is not None:
        earlier = measured if state.earlier is None else state.earlier
        position = measured
        velocity = (measured - earlier) / (state.interval * setup.config.loop.period)
    else:
        return None
    return TipEstimate(
        position=_vector(position),
        velocity=_vector(velocity),
        acceleration=_vector(tip.acceleration),
        offset=_vector(state.observer.offset),
    )


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
    )


def _pretension(setup: CycleSetup, state: CycleState) -> Array:
    """The agonist's tension on its way to the pretension [N], shape (n,)."""
    section = setup.config.pretension
    elapsed = (state.tick - state.since + 1) * setup.config.loop.period
    wanted = np.zeros_like(state.tension)
    wanted[setup.config.control.agonist] = section.tension * min(1.0, elapsed / max(section.duration, 1e-9))
    return wanted


def _advance_model(setup: CycleSetup, state: CycleState, tension: Array) -> tuple[CycleState, str]:
    """The model one step on, under the tension that is commanded; it stays where it is when there is no solution."""
    try:
        rod = setup.rod.step(state.rod, tension)
    except ConvergenceError as error:
        runs = replace(state.runs, solver_failures=state.runs.solver_failures + 1)
        return replace(state, runs=runs), str(error)
    return replace(state, rod=rod, runs=replace(state.runs, solver_failures=0)), ""


def _displacement(
    setup: CycleSetup, state: CycleState, tension: Array, model_error: str
) -> tuple[Array, tuple[str, ...]]:
    """Displacement of each tendon [m], shape (n,), within its limits, and the limits that it met.

    It follows from the model's shape. Without one, it is held while the arm is active, and let out in proportion to the
    tension while that is released.
    """
    config = setup.config
    if model_error:
        total = float(np.sum(state.tension))
        left = 1.0 if state.mode in ACTIVE else float(np.sum(tension)) / total if total > 0.0 else 0.0
        wanted = np.where(state.displacement > 0.0, left * state.displacement, state.displacement)
    else:
        wanted = setup.rod.displacements(state.rod, elastic=config.rod.tendon_stiffness is not None)
        wanted = np.where(tension > 0.0, wanted, wanted - config.limits.slack)
    return limit_displacement(config.limits, config.loop.period, wanted, state.displacement)


def _wanted(decision: Decision | None) -> tuple[float, ...] | None:
    if decision is None or not np.all(np.isfinite(decision.tension)):
        return None
    return _numbers(decision.tension)


def _numbers(values: Array) -> tuple[float, ...]:
    return tuple(values.tolist())


def _vector(values: Array) -> Vector3:
    x, y, z = values.tolist()
    return x, y, z
