"""One cycle of the controller: a pure function of setup, state and inputs. No clock, no I/O, no randomness.

The same `step` runs live and in lockstep with the simulator; run on recorded inputs it gives the recorded outputs.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.actuation import attainable, follow, lead, limit_displacement, limit_tension, share
from tendond.daemon.control.admission import admit, lengthened
from tendond.daemon.control.commissioning.probe import TAKE_UP, Phase, advance_probe, probe_tension
from tendond.daemon.control.laws.law import Observation
from tendond.daemon.control.modes import ACTIVE, Answer, advance_mode, enter, handle_request, slack_tendon, watch_rest
from tendond.daemon.control.monitors import watch_jumps, watch_pose_age, watch_reports, watch_tip
from tendond.daemon.control.prediction import look_ahead
from tendond.daemon.control.record import Response, write_record
from tendond.daemon.control.reference.planar import PLANES
from tendond.daemon.control.state import CycleSetup, CycleState, changed
from tendond.model.errors import ConvergenceError
from tendond.model.estimation.observer import observe
from tendond.schemas.base import SCHEMA_VERSION
from tendond.schemas.messages import Mode, TendonCommand
from tendond.schemas.record import CycleInputs, CycleRecord, ReferencePoint

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
    """One cycle: `respond`, and the record of it.

    The loop takes the two apart, to publish the command before it writes the record; all others call this.

    Args:
        setup: of the controller.
        state: after the last cycle; it stays as it is.
        inputs: what has arrived since.

    Returns:
        The new state, the command to publish, and the record of it all.
    """
    response = respond(setup, state, inputs)
    return response.state, response.command, write_record(setup, response)


def respond(setup: CycleSetup, state: CycleState, inputs: CycleInputs) -> Response:
    """A cycle as far as its command; arguments as in `step`."""
    config, period = setup.config, setup.config.loop.period
    admission = admit(setup, state, inputs)
    state = watch_rest(setup, admission.state, admission.fresh)
    state = watch_reports(setup, watch_pose_age(setup, state, inputs, admission.fresh))
    state, answer = _advance_mode(setup, state, inputs)
    fresh = np.array(state.pose.position) if admission.fresh and state.pose is not None else None
    state = _observe(setup, state, fresh)
    state = _probe(setup, state, admission.fresh)
    if state.jump_watch.withheld or (state.jump_watch.pose_distrusted and config.control.feedback == "direct"):
        fresh = None
    tip, selection = state.tip, state.selection
    elapsed = (state.tick - state.mode_since) * period if state.mode is Mode.TRACKING else 0.0
    reference = selection.reference.at(elapsed, state.reference_offset)

    state = watch_tip(setup, state, admission.fresh, reference)

    observation, decision = None, None
    if state.mode is Mode.TRACKING:
        observation = _observation(setup, state, fresh, reference)
        if observation is not None:
            ahead = look_ahead(setup, state, observation, elapsed) if selection.law.looks_ahead else observation
            decision = selection.law.decide(selection.parameters, ahead)
    wanted = state.tension_estimate if decision is None else decision.tension
    overbent = None
    if decision is not None and not selection.law.looks_ahead and config.control.feedback == "observer":
        overbent = selection.reference.overbent(tip.rotation[:, 2])
    if overbent is not None:  # an impact has thrown the arm over: back to where the law holds
        wanted = share(len(wanted), config.control.agonist, config.control.antagonist, overbent, 0.0)
    if state.mode is Mode.PRETENSION:
        wanted = _pretension(setup, state)
    if state.mode is Mode.PROBE and state.probe is not None:
        wanted = probe_tension(setup.probe, state.probe)
    limits = setup.probe_limits if state.mode is Mode.PROBE else config.limits
    if state.mode in ACTIVE:
        command, met = limit_tension(
            limits, period, lead(wanted, state.tension_estimate, setup.lag_factor), state.tension_command
        )
    else:
        command, met = np.maximum(state.tension_command - config.limits.release_rate * period, 0.0), ()

    wound = _wind(setup, state, command)
    if wound.met and state.mode in ACTIVE:  # what cannot be wound is not pulled
        held = _wind(setup, state, state.tension_estimate)
        part = attainable(held.asked, wound.asked, wound.command)
        met += wound.met
        reached = state.tension_estimate + part * (command - state.tension_estimate)
        step = limits.tension_rate * period  # where actuators lag, what was commanded is not what they stand at
        reached = np.clip(reached, state.tension_command - step, state.tension_command + step)
        # a tendon that is let go ends slack: a rest of its tension would hold its displacement at the rate's limit
        reached = np.where((command == 0.0) & (reached < SLACK), 0.0, reached)
        wound = held if np.array_equal(reached, held.state.tension_command) else _wind(setup, state, reached)
    state = wound.state
    command, displacement = state.tension_command, wound.command
    if not (_finite(command) and _finite(displacement)):
        state = enter(state, Mode.FAULT, "the command was not finite")
        displacement = command = np.zeros_like(command)
        state = changed(state, tension_command=command, tension_estimate=command, displacement_estimate=command)
    lagging = bool(wound.met) and state.mode not in ACTIVE
    slip = _slip(setup, state, elapsed, None if _held_back(met) else observation, reference)
    last = changed(
        state,
        tick=state.tick + 1,
        tip=setup.rod.tip(state.rod),
        displacement_command=displacement,
        release_pending=lagging,
        reference_offset=slip,
        bad_cycles=changed(state.bad_cycles, limited=state.bad_cycles.limited + 1 if _held_back(met) else 0),
    )
    return Response(
        state=last,
        command=_command(last),
        inputs=inputs,
        rejected=admission.rejected,
        answer=answer,
        reference=reference,
        observation=observation,
        decision=decision,
        limited=met,
        error=wound.error,
    )


def _command(state: CycleState) -> TendonCommand:
    """What the state after a cycle tells the tendons."""
    # Letting out what is wired wrongly may wind it: its torque is cut as soon as nothing pulls.
    let_out = state.release_pending and not (state.probe is not None and state.probe.verdict)
    armed = state.mode in (*ACTIVE, Mode.RELEASING) or (
        state.mode is Mode.FAULT and (let_out or bool((state.tension_command > 0.0).any()))
    )
    displacement = state.displacement_command.tolist() if armed else [0.0] * len(state.displacement_command)
    return TendonCommand.trusted(
        version=SCHEMA_VERSION,
        seq=state.tick - 1,
        stamp_ns=0,
        source="",
        pose_seq=None if state.pose is None else state.pose.seq,
        displacement=tuple(displacement),
        tension=tuple(state.tension_command.tolist()),
        armed=armed,
    )


def _advance_mode(setup: CycleSetup, state: CycleState, inputs: CycleInputs) -> tuple[CycleState, Answer]:
    """The operator's request first, then faults and the changes of mode that happen by themselves."""
    if state.mode is Mode.STARTING:
        state = enter(state, Mode.IDLE, "started")
    answer = Answer(False, "")
    if inputs.request is not None:
        state, answer = handle_request(setup, state, inputs)
    return advance_mode(setup, state), answer


def _observe(setup: CycleSetup, state: CycleState, fresh: Array | None) -> CycleState:
    """The observer's cycle, and what tells a frozen pose or another robot than the model from all is well."""
    probing = state.mode is Mode.PROBE and state.probe is not None and state.probe.phase is not Phase.REST
    if probing:  # the model runs freely, to be compared with
        fresh = None
    elif state.mode is Mode.PROBE and state.probe is not None and fresh is not None and state.pose is not None:
        fresh = np.array(state.probe.in_base(state.pose.position))
    observer = observe(setup.observer, state.observer, setup.rod, state.rod, state.tip.position, fresh)
    jump = watch_jumps(setup, state, fresh is not None, observer)
    if jump.withheld:
        fresh = None
        observer = observe(setup.observer, state.observer, setup.rod, state.rod, state.tip.position, None)
    way = state.path_length + setup.config.loop.period * math.hypot(*state.tip.velocity.tolist())
    runs = state.bad_cycles
    if fresh is not None:
        apart = math.hypot(*observer.innovation.tolist())
        gross = apart > setup.config.faults.mismatch * setup.rod.parameters.length
        if gross or runs.mismatches:
            runs = changed(runs, mismatches=lengthened(runs.mismatches, state.pose_interval) if gross else 0)
    if state.tendon_age == 0:  # an old report says nothing about a tension that has changed since
        slack = state.mode in ACTIVE and slack_tendon(setup, state) is not None
        if slack or runs.slack:
            runs = changed(runs, slack=lengthened(runs.slack, state.tendon_interval) if slack else 0)
    return changed(state, observer=observer, path_length=way, bad_cycles=runs, jump_watch=jump)


def _probe(setup: CycleSetup, state: CycleState, fresh: bool) -> CycleState:
    """The probe of the tendons, where one runs."""
    if state.mode is not Mode.PROBE or state.probe is None:
        return state
    pose = state.pose if fresh else None
    tendons = state.tendon_state if state.tendon_age == 0 else None
    tip, before = state.tip.position, state.displacement_command
    return changed(state, probe=advance_probe(setup.probe, state.probe, pose, tip, state.rest_watch, tendons, before))


def _observation(
    setup: CycleSetup, state: CycleState, fresh: Array | None, reference: ReferencePoint
) -> Observation | None:
    """What the law is fed; none when there is nothing fresh to feed it, and the command is held."""
    control, tip = setup.config.control, state.tip
    if control.feedback == "observer":
        position, velocity = tip.position + state.observer.offset, tip.velocity
    elif fresh is not None:
        earlier = fresh if state.previous_position is None else state.previous_position
        position = fresh
        velocity = (fresh - earlier) / (state.pose_interval * setup.config.loop.period)
    else:
        return None
    sampled = control.sampled and not state.selection.law.looks_ahead
    return Observation(
        position=position,
        velocity=velocity,
        acceleration=tip.acceleration,
        input_gain=tip.input_gain,
        response=setup.rod.velocity_jacobian(state.rod, control.agonist) if sampled else None,
        tension=state.tension_estimate,
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
    setup: CycleSetup, state: CycleState, elapsed: float, observation: Observation | None, reference: ReferencePoint
) -> float:
    """How far the reference has yielded along the straight rod [m]: under a load the same x is at another z.

    It yields where the tip has arrived and no limit holds it back.
    """
    if state.mode is not Mode.TRACKING:
        return 0.0
    if observation is None or not state.selection.reference.yields or elapsed < state.selection.reference.arrival:
        return state.reference_offset
    across, along = PLANES[setup.config.control.plane]
    position: list[float] = observation.position.tolist()
    if abs(position[across] - reference.position[across]) > ARRIVED * abs(reference.position[across]):
        return state.reference_offset
    slip = state.reference_offset + YIELD * (position[along] - reference.position[along])
    most = FARTHEST * setup.config.rod.length
    return min(most, max(-most, slip))


def _pretension(setup: CycleSetup, state: CycleState) -> Array:
    """Tensions on their way to the pretension [N], shape (n,)."""
    section, control = setup.config.pretension, setup.config.control
    elapsed = (state.tick - state.mode_since + 1) * setup.config.loop.period
    part = min(1.0, elapsed / max(section.duration, 1e-9))
    if state.selection.law.looks_ahead:
        return np.full(len(state.tension_estimate), part * section.tension_min)
    return part * share(
        len(state.tension_estimate), control.agonist, control.antagonist, section.tension, section.antagonist
    )


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
    tension = follow(command, state.tension_estimate, setup.lag_factor)
    if setup.lag_factor:
        tension = np.where((command == 0.0) & (tension < SLACK), 0.0, tension)
    after, error = _advance_model(setup, state, tension)
    if error:
        total = float(np.sum(state.tension_estimate))
        left = 1.0 if state.mode in ACTIVE else float(np.sum(tension)) / total if total > 0.0 else 0.0
        wanted = np.where(
            state.displacement_estimate > 0.0, left * state.displacement_estimate, state.displacement_estimate
        )
    else:
        wanted = setup.rod.displacements(after.rod, elastic=config.rod.tendon_stiffness is not None)
    let_out = max(config.limits.slack, setup.probe.slack) if state.mode is Mode.PROBE else config.limits.slack
    slack = np.where(tension > 0.0, 0.0, 0.0 if error else let_out)
    asked = lead(wanted - slack, state.displacement_estimate, setup.lag_factor)
    last, wound = state.displacement_command, state.displacement_estimate
    if state.mode is Mode.PROBE and state.probe is not None:  # slowly: what is wired wrongly is wound by any of it
        rests = state.probe.phase is Phase.REST
        if rests and state.probe.since <= 1:
            last = wound = wanted if state.probe.held is None else np.array(state.probe.held)
        slow = setup.probe.rate * config.loop.period
        up, down = (slow, slow) if rests else (TAKE_UP * slow, config.limits.displacement_rate * config.loop.period)
        if rests and state.probe.held is not None:  # only out: the model may still be on its way to the arm
            wanted = np.minimum(wanted, state.probe.held)
        asked = np.clip(wanted - slack, last - down, last + up)
    displacement, met = limit_displacement(config.limits, config.loop.period, asked, last)
    after = changed(
        after,
        tension_estimate=tension,
        tension_command=command,
        displacement_estimate=follow(displacement, wound, setup.lag_factor),
    )
    return _Wound(after, asked, displacement, met, error)


def _advance_model(setup: CycleSetup, state: CycleState, tension: Array) -> tuple[CycleState, str]:
    """The model one step on; where that has no solution, without the observer's pull; else it stays where it is."""
    observer, error = state.observer, ""
    for force in (observer.tip_force, observer.force):
        try:
            rod = setup.rod.step(state.rod, tension, tip_force=force)
            return changed(state, rod=rod, bad_cycles=changed(state.bad_cycles, solver_failures=0)), ""
        except ConvergenceError as failure:
            error = str(failure)
    runs = changed(state.bad_cycles, solver_failures=state.bad_cycles.solver_failures + 1)
    return changed(state, bad_cycles=runs), error


def _held_back(met: tuple[str, ...]) -> bool:
    """Whether a limit keeps a command from what the law wants; the least tension only keeps the others taut."""
    return any(name != "tension min" for name in met)


def _finite(values: Array) -> bool:
    return all(map(math.isfinite, values.tolist()))
