"""Advance mode: the requests that an operator may make in each mode, and the reasons that end tracking.

idle -> (arm) -> probe, the first time -> pretension -> tracking -> (stop) -> releasing -> idle
any but idle and releasing -> fault, until reset
"""

from dataclasses import dataclass

import numpy as np

from tendond.daemon.control.commissioning.averages import RestWatch
from tendond.daemon.control.commissioning.probe import Probe, start_probe
from tendond.daemon.control.commissioning.probe_plan import Phase
from tendond.daemon.control.commissioning.rest_check import rest_objection
from tendond.daemon.control.phases.admission import describe_refusals
from tendond.daemon.control.phases.faults import find_fault, in_seconds, sensor_silence
from tendond.daemon.control.phases.monitors import (
    pose_age_objection,
    watch_pose_age,
    watch_reports,
)
from tendond.daemon.control.safety.configured import target_remark
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import BadCycles, CycleState, changed, started_observer
from tendond.daemon.control.tuning.request import retune
from tendond.daemon.errors import DaemonError
from tendond.model.errors import ModelError
from tendond.schemas.messages import ACTIVE as ACTIVE
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction

ARMED, PROBING = "armed by the operator", "probing the tendons"


@dataclass(frozen=True)
class Reply:
    """Reply to an operator's request: whether it was carried out, and what was done or why not."""

    accepted: bool
    text: str


def enter(state: CycleState, mode: Mode, reason: str) -> CycleState:
    """`state` in another mode."""
    return changed(state, mode=mode, reason=reason, mode_since=state.tick)


def pulls(state: CycleState) -> bool:
    """True if a tendon has tension."""
    return bool(np.any(state.tension_command > 0.0)) or bool(np.any(state.tension_estimate > 0.0))


def is_taut(state: CycleState) -> bool:
    """True if a tendon may still pull: it has tension, or its displacement is not released yet."""
    return pulls(state) or state.release_pending


def advance_mode(setup: CycleSetup, state: CycleState, inputs: CycleInputs, fresh: bool) -> tuple[CycleState, Reply]:
    """Watch the inputs, carry out the operator's request, then change the mode for faults and by itself.

    Args:
        setup: setup of the cycle.
        state: state with the admitted inputs.
        inputs: inputs of the cycle.
        fresh: a pose was admitted in this cycle.
    """
    state = watch_rest(setup, state, fresh)
    state = watch_reports(setup, watch_pose_age(setup, state, inputs, fresh))
    if state.mode is Mode.STARTING:
        state = enter(state, Mode.IDLE, "started")
    reply = Reply(False, "")
    if inputs.request is not None:
        state, reply = handle_request(setup, state, inputs)
    return change_mode(setup, state), reply


def watch_rest(setup: CycleSetup, state: CycleState, fresh: bool) -> CycleState:
    """Average the poses of a tip without tension in any tendon; `fresh`: the pose is new."""
    resting = state.probe is not None and state.probe.phase is Phase.REST
    if (state.mode in (Mode.STARTING, Mode.IDLE) or (state.mode is Mode.PROBE and resting)) and not pulls(state):
        pose = state.pose if fresh else None
        block = setup.thresholds.rest_block
        watch = (
            state.rest_watch.add(None, None, block)
            if pose is None
            else state.rest_watch.add(pose.position, pose.orientation, block)
        )
        return changed(state, rest_watch=watch)
    return state if state.rest_watch.cycles == 0 else changed(state, rest_watch=RestWatch())


def _with_model_at_rest(setup: CycleSetup, state: CycleState) -> CycleState:
    """Return the state with the model solved anew, slack and at rest."""
    rod = setup.rod.solve_static(np.zeros_like(state.tension_estimate))
    tip = setup.rod.tip(rod)
    return changed(state, rod=rod, tip=tip, observer=started_observer(setup, rod, tip))


def handle_request(setup: CycleSetup, state: CycleState, inputs: CycleInputs) -> tuple[CycleState, Reply]:
    """Carry out a request, or say why not."""
    action = inputs.request
    if action in (ControlAction.LAW, ControlAction.REFERENCE):
        return _select(setup, state, inputs)
    if action is ControlAction.JOG:
        return state, Reply(False, "")  # by the phase that moves the target
    if action is ControlAction.SET:
        return _tune(setup, state, inputs)
    if action in (ControlAction.ARM, ControlAction.PROBE):
        refusal = _arming_refused(setup, state)
        if refusal:
            done = "armed" if action is ControlAction.ARM else "probed"
            return state, Reply(False, f"not {done}: {refusal}")
        return _arm(setup, state, probe_only=action is ControlAction.PROBE)
    if action is ControlAction.STOP:
        if state.mode in ACTIVE:
            return enter(state, Mode.RELEASING, "asked to stop"), Reply(True, "stopped: releasing the tendons")
        if state.mode is Mode.FAULT:
            return state, Reply(True, "in fault: the tendons are released already")
        return state, Reply(True, f"nothing to stop: {state.mode.value}")
    if action is ControlAction.RESET:
        if state.mode is not Mode.FAULT:
            return state, Reply(False, f"nothing to reset: {state.mode.value}")
        if is_taut(state):
            return state, Reply(False, "not reset: the tendons are still being released")
        if state.bad_cycles.solver_failures:
            state = _with_model_at_rest(setup, state)
        state = changed(state, bad_cycles=BadCycles(), commissioned=False)
        return enter(state, Mode.IDLE, "reset by the operator"), Reply(True, "reset")
    return state, Reply(True, state.mode.value)


def _arm(setup: CycleSetup, state: CycleState, *, probe_only: bool) -> tuple[CycleState, Reply]:
    """Pretension, after the probe of the tendons where one is due, or asked for by itself."""
    state = changed(state, bad_cycles=BadCycles())
    due = setup.config.commissioning.probe and not state.commissioned
    remark = target_remark(setup.barrier, state.selection.reference.target)
    note = f"; {remark}" if remark else ""
    if not (due or probe_only):
        return enter(state, Mode.PRETENSION, ARMED), Reply(True, f"armed{note}")
    report = state.tendon_state
    held = (
        None
        if report is None or len(report.displacement) != len(state.tension_estimate)
        else tuple(report.displacement)
    )
    state = enter(
        changed(state, probe=start_probe(setup.rests, state.rest_watch, held, only=probe_only)),
        Mode.PROBE,
        PROBING if probe_only else ARMED,
    )
    return state, Reply(True, PROBING if probe_only else f"armed: {PROBING}{note}")


def _end_probe(state: CycleState, probe: Probe) -> CycleState:
    """Enter pretension if all tendons passed, release where only the probe was asked for, else enter a fault."""
    if probe.verdict:
        return enter(changed(state, commissioned=False), Mode.FAULT, f"wiring: {probe.verdict}")
    state = changed(state, commissioned=True)
    if not probe.only:
        return enter(state, Mode.PRETENSION, ARMED)
    gains = ", ".join(f"{motion.gain:.2f}" for motion in probe.motions)
    return enter(state, Mode.RELEASING, f"probed: every tendon moves the tip as the model says (times {gains})")


def _select(setup: CycleSetup, state: CycleState, inputs: CycleInputs) -> tuple[CycleState, Reply]:
    """Select another law or reference, validated as the configuration's; only while nothing moves."""
    if state.mode is not Mode.IDLE:
        remedy = "reset" if state.mode is Mode.FAULT else "stop"
        return state, Reply(False, f"not changed: {state.mode.value}; {remedy} first")
    try:
        if inputs.law is not None:
            selection = state.selection.with_law(setup.config, setup.rod, inputs.law)
            done = f"law: {inputs.law}"
        elif inputs.reference is not None:
            selection = state.selection.with_reference(setup.config, setup.rod, inputs.reference, setup.plans)
            x, y, z = selection.reference.target
            done = f"reference: {inputs.reference.kind}, to ({x:.4f}, {y:.4f}, {z:.4f}) m"
            done = "; ".join([done, *selection.reference.notes])
        else:
            return state, Reply(False, "not changed: the request does not say to what")
    except (DaemonError, ModelError) as error:
        return state, Reply(False, "not changed: " + "; ".join(str(error).splitlines()))
    return changed(state, selection=selection), Reply(True, done)


def _tune(setup: CycleSetup, state: CycleState, inputs: CycleInputs) -> tuple[CycleState, Reply]:
    """Take other values of gains and limits as wanted; they move there in the cycles that follow."""
    try:
        tuning, done = retune(setup, state.mode, state.tuning, inputs.settings)
    except DaemonError as error:
        return state, Reply(False, "not set: " + "; ".join(str(error).splitlines()))
    return changed(state, tuning=tuning), Reply(True, done)


def _arming_refused(setup: CycleSetup, state: CycleState) -> str:
    if state.mode is Mode.FAULT:
        return f"in fault ({state.reason}); reset first"
    if state.mode is not Mode.IDLE:
        return f"already {state.mode.value}"
    if second_source := state.sources.in_words():
        return second_source
    if state.pose_age is None:
        return describe_refusals(state) or "no pose of the tip has arrived yet"
    if state.pose_age > setup.thresholds.pose_timeout:
        return f"the newest pose is {in_seconds(setup, state.pose_age)} old"
    if state.tendon_state is None and setup.config.servo is not None:
        return "the servo driver has not reported yet"
    if state.tendon_state is not None and state.tendon_state.fault:
        return f"the tendon driver reports {state.tendon_state.fault}"
    if state.tendon_state is not None and state.tendon_age > setup.thresholds.tendon_timeout:
        return f"the tendon driver has said nothing for {in_seconds(setup, state.tendon_age)}"
    if silent := sensor_silence(setup, state):
        return silent
    if state.bad_cycles.solver_failures:
        return "the model has no solution"
    if old := pose_age_objection(setup, state, 1):
        return old
    return "" if setup.rests is None else rest_objection(setup.rests, state.rest_watch)


def _restart_lost_model(setup: CycleSetup, state: CycleState) -> CycleState:
    """Restart a model at rest that has long been far from a released arm, which rests."""
    if state.mode in ACTIVE or state.bad_cycles.mismatches < setup.thresholds.mismatch_time:
        return state
    if pulls(state):
        return state
    return changed(_with_model_at_rest(setup, state), bad_cycles=changed(state.bad_cycles, mismatches=0))


def change_mode(setup: CycleSetup, state: CycleState) -> CycleState:
    """Enter the mode that a fault or the state itself requires."""
    state = _restart_lost_model(setup, state)
    if state.mode in ACTIVE:
        fault = find_fault(setup, state)
        if fault:
            return enter(state, Mode.FAULT, fault)
    if state.mode is Mode.PROBE and state.probe is not None and state.probe.phase is Phase.DONE:
        return _end_probe(state, state.probe)
    if state.mode is Mode.PRETENSION:
        duration = setup.config.pretension.duration / setup.config.loop.period
        if state.tick - state.mode_since >= duration:
            return enter(state, Mode.TRACKING, state.reason)
    if state.mode is Mode.RELEASING and not is_taut(state):
        return enter(state, Mode.IDLE, f"released: {state.reason}")
    return state
