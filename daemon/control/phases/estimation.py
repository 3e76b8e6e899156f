"""Estimate: the tip by observer and model, jumps and mismatches of the measurement, and the probe of the tendons."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.commissioning.probe_advance import advance_probe
from tendond.daemon.control.commissioning.probe_plan import Phase
from tendond.daemon.control.estimation.estimator import other_readings, pose_reading
from tendond.daemon.control.phases.admission import lengthened
from tendond.daemon.control.phases.faults import slack_tendon
from tendond.daemon.control.phases.modes import ACTIVE
from tendond.daemon.control.phases.monitors import watch_jumps
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, TipCorrection, changed
from tendond.model.estimation.kalman.state import EstimatorState
from tendond.model.estimation.observer import ObserverState, observe
from tendond.model.rods.general import GeneralState
from tendond.model.rods.interface import ModelState
from tendond.schemas.messages import Mode

Array = NDArray[np.float64]


def estimate(setup: CycleSetup, state: CycleState, fresh: bool) -> tuple[CycleState, Array | None]:
    """Return the state with tip, observer and probe of this cycle, and the measured tip [m] that a law may use.

    Args:
        setup: setup of the cycle.
        state: state with the admitted pose.
        fresh: the pose was admitted in this cycle.
    """
    measured = np.array(state.pose.position) if fresh and state.pose is not None else None
    state = _probe(setup, _observe(setup, _correct(setup, state), measured), fresh)
    jump = state.jump_watch
    if jump.withheld or (jump.pose_distrusted and setup.config.control.feedback == "direct"):
        return state, None
    return state, measured


def _correct(setup: CycleSetup, state: CycleState) -> CycleState:
    """Return the state with the learned correction of the model's tip, where one is configured."""
    residual, drawn = setup.residual, state.displacement_estimate
    if residual is None:
        return state
    held = residual.play(drawn if state.correction is None else state.correction.held, drawn)
    return changed(state, correction=TipCorrection(held, residual.shift(drawn[None], held[None])[0]))


def corrected_tip(state: CycleState) -> Array:
    """Return the model's tip with its learned correction [m], shape (3,)."""
    return state.tip.position if state.correction is None else state.tip.position + state.correction.shift


def _observe(setup: CycleSetup, state: CycleState, measured: Array | None) -> CycleState:
    """Run the observer, and count the signs of a frozen pose and of another robot than the model."""
    probing = state.mode is Mode.PROBE and state.probe is not None and state.probe.phase is not Phase.REST
    if probing:  # the model runs freely, to be compared with
        measured = None
    elif state.mode is Mode.PROBE and state.probe is not None and measured is not None and state.pose is not None:
        measured = np.array(state.probe.in_base(state.pose.position))
    known = _known(setup, state, measured)
    jump = watch_jumps(setup, state, measured is not None, known.observer.innovation)
    if jump.withheld:
        measured = None
        known = _known(setup, state, None)
    observer = known.observer
    path_length = state.path_length + setup.config.loop.period * math.hypot(*state.tip.velocity.tolist())
    bad = state.bad_cycles
    if measured is not None:
        apart = math.hypot(*observer.innovation.tolist())
        gross = apart > setup.config.faults.mismatch * setup.rod.parameters.length
        if gross or bad.mismatches:
            bad = changed(bad, mismatches=lengthened(bad.mismatches, state.pose_interval) if gross else 0)
    if state.tendon_age == 0:  # an old report says nothing about a tension that has changed since
        slack = state.mode in ACTIVE and slack_tendon(setup, state) is not None
        if slack or bad.slack:
            bad = changed(bad, slack=lengthened(bad.slack, state.tendon_interval) if slack else 0)
    tip = state.tip if known.rod is state.rod else setup.rod.tip(known.rod)
    return changed(
        state, observer=observer, rod=known.rod, tip=tip, path_length=path_length, bad_cycles=bad, jump_watch=jump
    )


class _Known(NamedTuple):
    """State of the observer, and of the model, which an estimator moves."""

    observer: ObserverState | EstimatorState
    rod: ModelState


def _known(setup: CycleSetup, state: CycleState, measured: Array | None) -> _Known:
    """Run the observer, or the estimator in its place, on a measured tip [m], shape (3,), if there is one."""
    observer, age = state.observer, _age(setup, state)
    if setup.estimator is None or isinstance(observer, ObserverState):
        assert isinstance(observer, ObserverState)
        return _Known(
            observe(setup.observer, observer, setup.rod, state.rod, corrected_tip(state), measured, age), state.rod
        )
    probing = state.mode is Mode.PROBE  # only the place of the tip counts then: where it points to is being asked
    readings = [] if probing else other_readings(setup.config, state.readings)
    if measured is not None and state.pose is not None:
        place = measured if state.correction is None else measured - state.correction.shift
        turned = None if probing else state.pose.orientation
        readings.insert(0, pose_reading(place, turned, setup.observer.delay if age is None else age))
    assert isinstance(state.rod, GeneralState)
    rod = state.rod
    if state.mode not in ACTIVE:  # while tracking it is a fault
        observer, rod = setup.estimator.begun_again(observer, rod)
    return _Known(*setup.estimator.correct(observer, rod, readings))


def _age(setup: CycleSetup, state: CycleState) -> float | None:
    """Return the age of the newest pose against the model [s], by its stamp; none where it is the configured one."""
    section = setup.config.observer
    if not section.stamps or state.stamp_age.stamp_ns < 0:
        return None
    return state.stamp_age.seconds + section.command_delay


def _probe(setup: CycleSetup, state: CycleState, fresh: bool) -> CycleState:
    """Advance the probe of the tendons, where one runs."""
    if state.mode is not Mode.PROBE or state.probe is None:
        return state
    pose = state.pose if fresh else None
    tendons = state.tendon_state if state.tendon_age == 0 else None
    probe = advance_probe(
        setup.probe, state.probe, pose, state.tip.position, state.rest_watch, tendons, state.displacement_command
    )
    return changed(state, probe=probe)
