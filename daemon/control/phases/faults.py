"""Faults: the reasons to end pretension or tracking, by the counts of bad cycles and the watches."""

import numpy as np

from tendond.daemon.control.phases.monitors import (
    monitored_fault,
)
from tendond.daemon.control.sensors import silent_sensor
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState
from tendond.model.estimation.kalman.state import EstimatorState
from tendond.schemas.messages import Mode


def find_fault(setup: CycleSetup, state: CycleState) -> str:
    """Return the reason to end pretension or tracking now; empty if there is none."""
    limits, bad, allowed = setup.config.faults, state.bad_cycles, setup.thresholds
    if second_source := state.sources.in_words():
        return second_source
    if bad.missed_ticks >= allowed.overrun_time:
        return f"overrun: {bad.missed_ticks} deadlines missed in a row"
    if state.pose_age is None or state.pose_age > allowed.pose_timeout:
        if state.pose_age is None:
            return "no pose"
        cause = "occluded: the tip was not seen" if bad.occluded else "pose stale: none accepted"
        return f"{cause} for {in_seconds(setup, state.pose_age)}"
    if bad.teleports >= allowed.teleport_time:
        return f"teleport: poses beyond what the tip can do for {in_seconds(setup, bad.teleports)}"
    if bad.rejected >= allowed.rejected_time:
        return f"bad poses: {bad.objection or 'unreadable'} for {in_seconds(setup, bad.rejected)}"
    if bad.solver_failures > allowed.solver_timeout:
        return f"model: no solution for {in_seconds(setup, bad.solver_failures)}"
    if bad.limited >= allowed.limit_time:
        met = f": {', '.join(bad.limits)}" if bad.limits else ""
        return f"limits: the command stood at one for {in_seconds(setup, bad.limited)}{met}"
    if bad.unsafe >= allowed.unsafe_time:
        return f"safety: no command keeps the constraints of [safety] for {in_seconds(setup, bad.unsafe)}"
    if state.tendon_state is not None and state.tendon_state.fault:
        return f"tendons: {state.tendon_state.fault}"
    if state.tendon_state is not None and state.tendon_age > allowed.tendon_timeout:
        return f"tendons stale: no state for {in_seconds(setup, state.tendon_age)}"
    if silent := sensor_silence(setup, state):
        return silent
    if (
        state.mode is not Mode.PROBE
        and bad.equal_poses >= allowed.frozen_time
        and state.path_length > limits.frozen_distance
    ):
        duration = in_seconds(setup, bad.equal_poses)
        return f"pose frozen: equal ones for {duration} while the model's tip went {state.path_length * 1e3:.0f} mm"
    if bad.mismatches >= allowed.mismatch_time:
        apart = float(np.linalg.norm(state.observer.innovation)) * 1e3
        return f"mismatch: model and measured tip {apart:.0f} mm apart, too far for {in_seconds(setup, bad.mismatches)}"
    if inconsistent := inconsistency(setup, state):
        return inconsistent
    if monitored := monitored_fault(setup, state):
        return monitored
    if bad.slack >= allowed.slack_time and (tendon := slack_tendon(setup, state)) is not None:
        assert state.tendon_state is not None
        return (
            f"tendon {tendon} slack: {state.tendon_state.tension[tendon]:.1f} N reported where the model has "
            f"{state.tension_estimate[tendon]:.1f} N, for {in_seconds(setup, bad.slack)}; is it cut, or off its spool?"
        )
    return ""


def sensor_silence(setup: CycleSetup, state: CycleState) -> str:
    """Say that a required sensor is silent; empty where none is."""
    if (name := silent_sensor(setup.sensors, state.sensors)) is None:
        return ""
    track = state.sensors[name]
    since = "yet" if track.age is None else f"for {in_seconds(setup, track.age)}"
    return f"sensor '{name}' silent: no reading {since}{track.objection and f', the newest: {track.objection}'}"


def inconsistency(setup: CycleSetup, state: CycleState) -> str:
    """Say that the estimator has lost the robot; empty where it has not."""
    observer, largest = state.observer, setup.config.faults.inconsistency
    if not isinstance(observer, EstimatorState) or not observer.consistency > largest:
        return ""
    far, allowed = observer.consistency**0.5, largest**0.5
    return (
        f"inconsistency: what is measured is {far:.1f} times as far from the estimate as its noise allows, where "
        f"faults.inconsistency allows {allowed:.1f}; is the robot the configured one, and is anything touching it?"
    )


def in_seconds(setup: CycleSetup, cycles: int) -> str:
    """Format a number of cycles as a time."""
    return f"{cycles * setup.config.loop.period:.3g} s"


def slack_tendon(setup: CycleSetup, state: CycleState) -> int | None:
    """Index of a tendon that ought to pull and is reported not to; none if there is none."""
    limits, reported = setup.config.faults, state.tendon_state
    if reported is None or len(reported.tension) != len(state.tension_estimate):
        return None
    for index, (reported_tension, expected) in enumerate(
        zip(reported.tension, state.tension_estimate.tolist(), strict=True)
    ):
        if expected > limits.slack_tension and abs(reported_tension) < limits.slack_fraction * expected:
            return index
    return None
