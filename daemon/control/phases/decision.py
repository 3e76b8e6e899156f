"""Decide: the tension wanted in this cycle, by the law, the pretension or the probe."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.commissioning.probe import probe_tension
from tendond.daemon.control.law_state import LawState
from tendond.daemon.control.phases.estimation import corrected_tip
from tendond.daemon.control.reference.load_offset import moved_point
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState
from tendond.daemon.control.tasks.decision import Decision
from tendond.daemon.control.tasks.task import Ruling, Situation
from tendond.model.estimation.kalman.state import EstimatorState
from tendond.schemas.messages import Mode
from tendond.schemas.record import ReferencePoint

Array = NDArray[np.float64]


class Wanted(NamedTuple):
    """The tension wanted, with the input and the output of the law.

    Attributes:
        tension: before any limit [N], shape (n,).
        situation: input of the law; none where it did not run: not tracking, or no tip to feed it.
        decision: output of the law; none likewise.
        law_state: state of the law after it; none while not tracking.
    """

    tension: Array
    situation: Situation | None
    decision: Decision | None
    law_state: LawState | None


def decide(setup: CycleSetup, state: CycleState, measured: Array | None, reference: ReferencePoint) -> Wanted:
    """Return the tension wanted: in tracking the law's, in pretension a ramp, in the probe its pulls.

    Without a tip to feed the law, and in all other modes, it is the present one.

    Args:
        setup: setup of the cycle.
        state: state with this cycle's estimate.
        measured: measured tip [m], shape (3,), if there is a new one.
        reference: point of the reference now.
    """
    if state.mode is Mode.PRETENSION:
        return Wanted(state.selection.task.pretension(_pretension_fraction(setup, state)), None, None, None)
    if state.mode is Mode.PROBE and state.probe is not None:
        return Wanted(probe_tension(setup.probe, state.probe), None, None, None)
    if state.mode is not Mode.TRACKING:
        return Wanted(state.tension_estimate, None, None, None)
    situation = _situation(setup, state, measured, reference)
    if situation is None:
        return Wanted(state.tension_estimate, None, None, state.law_state)
    ruling, law_state = _run_law(state, situation)
    return Wanted(ruling.tension, situation, ruling.decision, law_state)


def _run_law(state: CycleState, situation: Situation) -> tuple[Ruling, LawState | None]:
    """Run the selected law with its state; tracking begins with the law's own."""
    selection = state.selection
    law = selection.law
    parameters = state.tuning.parameters_of(selection.law_name, selection.parameters)
    before: Any = law.start(parameters) if state.law_state is None else state.law_state.value
    ruling = selection.task.rule(lambda observation: law.decide(parameters, observation, before), situation)
    after = ruling.decision.state
    return ruling, None if after is None else LawState(law.name, after)


def _situation(
    setup: CycleSetup, state: CycleState, measured: Array | None, reference: ReferencePoint
) -> Situation | None:
    """Return what is known of the tip; none where feedback is direct and there is no new pose: the command is held."""
    tip, period, ahead = state.tip, setup.config.loop.period, setup.config.observer.command_delay
    if setup.config.control.feedback == "observer":
        position, velocity = corrected_tip(state) + state.observer.offset, tip.velocity
    elif measured is not None:
        previous = measured if state.previous_position is None else state.previous_position
        position = measured
        velocity = (measured - previous) / (state.pose_interval * period)
    else:
        return None
    elapsed, offset = tracking_time(setup, state), state.reference_offset
    if ahead:  # the model is where the plant will be by then
        elapsed += ahead
        reference = moved_point(state.selection.task.reference.at(elapsed), offset)
    return Situation(
        setup.rod,
        state.rod,
        tip,
        state.tension_estimate,
        acting_tension(state),
        state.observer,
        position,
        velocity,
        reference,
        elapsed,
        offset,
        state.tension_command,
        state.displacement_estimate,
    )


def acting_tension(state: CycleState) -> Array:
    """Return the tensions that act on the model [N], shape (n,): those applied, with their estimated errors."""
    observer = state.observer
    return observer.acting(state.tension_estimate) if isinstance(observer, EstimatorState) else state.tension_estimate


def tracking_time(setup: CycleSetup, state: CycleState) -> float:
    """Return the time since tracking began [s]; zero in other modes."""
    return (state.tick - state.mode_since) * setup.config.loop.period if state.mode is Mode.TRACKING else 0.0


def _pretension_fraction(setup: CycleSetup, state: CycleState) -> float:
    """Return the fraction of the pretension's ramp that is done at the end of this cycle."""
    elapsed = (state.tick - state.mode_since + 1) * setup.config.loop.period
    return min(1.0, elapsed / max(setup.config.pretension.duration, 1e-9))
