"""One cycle of the controller: a pure function of setup, state and inputs. No clock, no I/O, no randomness.

The same `step` runs live and in lockstep with the simulator; on recorded inputs it returns the recorded outputs.
"""

from tendond.daemon.control.phases.admission import admit
from tendond.daemon.control.phases.decision import Wanted, decide, tracking_time
from tendond.daemon.control.phases.estimation import estimate
from tendond.daemon.control.phases.jogging import jog
from tendond.daemon.control.phases.modes import ACTIVE, advance_mode
from tendond.daemon.control.phases.monitors import watch_tip
from tendond.daemon.control.phases.prediction import Predicted, limit, predict
from tendond.daemon.control.phases.protection import protect
from tendond.daemon.control.record import Response, write_record
from tendond.daemon.control.reference.load_offset import moved_point
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, changed
from tendond.schemas.base import SCHEMA_VERSION
from tendond.schemas.messages import Mode, TendonCommand
from tendond.schemas.record import CycleInputs, CycleRecord, ReferencePoint


def step(setup: CycleSetup, state: CycleState, inputs: CycleInputs) -> tuple[CycleState, TendonCommand, CycleRecord]:
    """Run one cycle: `respond`, and the record of it.

    The loop takes the two apart, to publish the command before it writes the record; all others call this.

    Args:
        setup: setup of the controller.
        state: state after the last cycle; it is not changed.
        inputs: what has arrived since.

    Returns:
        The new state, the command to publish, and the record of the cycle.
    """
    response = respond(setup, state, inputs)
    return response.state, response.command, write_record(setup, response)


def respond(setup: CycleSetup, state: CycleState, inputs: CycleInputs) -> Response:
    """Run one cycle up to its command, phase by phase; arguments as in `step`."""
    state = advance_tuning(setup, state)
    admission = admit(setup, state, inputs)
    state, reply = advance_mode(setup, admission.state, inputs, admission.fresh)
    selection = state.selection
    state, reply = jog(setup, state, inputs, reply)
    state, measured = estimate(setup, state, admission.fresh)
    state, reference = refer(setup, state, admission.fresh)
    wanted = decide(setup, state, measured, reference)
    setup = state.tuning.applied_to(setup)
    protected = protect(setup, state, limit(setup, state, wanted.tension))
    predicted = predict(setup, protected.state, protected.limited)
    state = conclude(setup, predicted, wanted, reference, altered=protected.intervention is not None)
    if state.selection is not selection:  # that of a target in motion by hand is made anew in each cycle
        state = changed(state, selection=selection)
    return Response(
        state=state,
        command=command_of(state),
        inputs=inputs,
        rejected=admission.rejected,
        reply=reply,
        reference=reference,
        situation=wanted.situation,
        decision=wanted.decision,
        limited=predicted.met,
        safety=protected.intervention,
        error=predicted.error,
    )


def advance_tuning(setup: CycleSetup, state: CycleState) -> CycleState:
    """Move tuned gains and limits by a cycle towards what was asked for."""
    tuning = state.tuning.advance(setup)
    return state if tuning is state.tuning else changed(state, tuning=tuning)


def refer(setup: CycleSetup, state: CycleState, fresh: bool) -> tuple[CycleState, ReferencePoint]:
    """Evaluate the reference, and watch the measured tip against it; `fresh`: its pose was admitted in this cycle."""
    reference = moved_point(state.selection.task.reference.at(tracking_time(setup, state)), state.reference_offset)
    return watch_tip(setup, state, fresh, reference), reference


def conclude(
    setup: CycleSetup, predicted: Predicted, wanted: Wanted, reference: ReferencePoint, *, altered: bool = False
) -> CycleState:
    """Return the state for the next cycle: the model's new tip, the reference's offset, and runs at a limit.

    `altered`: the safety filter holds the tip back.
    """
    state = predicted.state
    held_back = any(name != "tension min" for name in predicted.met)  # the minimum only keeps the others taut
    bad = state.bad_cycles
    if held_back or bad.limited:
        bad = changed(bad, limited=bad.limited + 1 if held_back else 0, limits=predicted.met)
    return changed(
        state,
        tick=state.tick + 1,
        tip=setup.rod.tip(state.rod),
        release_pending=predicted.held_back and state.mode not in ACTIVE,
        reference_offset=_next_offset(state, None if held_back or altered else wanted, reference),
        law_state=wanted.law_state,
        bad_cycles=bad,
    )


def _next_offset(state: CycleState, wanted: Wanted | None, reference: ReferencePoint) -> float:
    """Return the offset of the reference for the next cycle [m]; it changes only where no limit holds the tip back."""
    if state.mode is not Mode.TRACKING:
        return 0.0
    rule = state.selection.task.reference.load_offset
    if rule is None or wanted is None or wanted.situation is None:
        return state.reference_offset
    situation = wanted.situation
    return rule.advance(state.reference_offset, situation.position, situation.reference, situation.elapsed)


def command_of(state: CycleState) -> TendonCommand:
    """Return the command to the tendons after a cycle."""
    # Releasing what is wired wrongly may pull it: its torque is cut as soon as no tension is commanded.
    releasing = state.release_pending and not (state.probe is not None and state.probe.verdict)
    armed = state.mode in (*ACTIVE, Mode.RELEASING) or (
        state.mode is Mode.FAULT and (releasing or bool((state.tension_command > 0.0).any()))
    )
    displacement = state.displacement_command
    return TendonCommand.trusted(
        version=SCHEMA_VERSION,
        seq=state.tick - 1,
        stamp_ns=0,
        source="",
        pose_seq=None if state.pose is None else state.pose.seq,
        displacement=tuple(displacement.tolist() if armed else [0.0] * len(displacement)),
        tension=tuple(state.tension_command.tolist()),
        armed=armed,
    )
