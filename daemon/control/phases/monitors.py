"""Watches of an active rig: reports of the tendons, age and jumps of the poses, the tip against its reference.

The tolerances and the watches themselves are in `commissioning/tracking.py`; here they are fed from the state.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.commissioning.jump import JumpWatch, watch_jump
from tendond.daemon.control.commissioning.tracking import TrackingWatch, tip_angle, tracking_fault, watch_tracking
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, PoseAge, changed
from tendond.model.numerics.rotation import quaternion
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs, ReferencePoint

Array = NDArray[np.float64]

ONE_CLOCK = 10.0
"""Difference from the receiver's clock [s] beyond which a stamp is of another clock: only its age's growth counts."""

CLOCK_DRIFT = 1e-4
"""Largest relative drift of two clocks."""

WATCHED = (Mode.PRETENSION, Mode.TRACKING)


def watch_pose_age(setup: CycleSetup, state: CycleState, inputs: CycleInputs, fresh: bool) -> CycleState:
    """Return the state with the age of a fresh pose, by its stamp; `fresh`: the pose was admitted."""
    lag, pose = inputs.pose_lag, inputs.pose
    if lag is None or pose is None or not fresh or pose.stamp_ns == state.stamp_age.stamp_ns:
        return state
    bounds = setup.tracking_bounds
    drift = CLOCK_DRIFT * state.pose_interval * setup.config.loop.period
    lag_min = min(lag, state.stamp_age.lag_min + drift)
    age = lag if 0.0 <= lag < ONE_CLOCK else lag - lag_min
    run = state.stamp_age.too_old + state.pose_interval if age > bounds.pose_age_max else 0
    return changed(state, stamp_age=PoseAge(stamp_ns=pose.stamp_ns, seconds=age, lag_min=lag_min, too_old=run))


def pose_age_objection(setup: CycleSetup, state: CycleState, run: int) -> str:
    """Say that the poses are too old to be used; empty while they have not been for `run` cycles."""
    bounds = setup.tracking_bounds
    if state.stamp_age.too_old < run:
        return ""
    return (
        f"poses are {state.stamp_age.seconds * 1e3:.0f} ms old, where observer.delay and faults.pose_age allow "
        f"{bounds.pose_age_max * 1e3:.0f} ms: find what delays them, or set observer.delay"
    )


def watch_reports(setup: CycleSetup, state: CycleState) -> CycleState:
    """Return the state with what the tendons report, against limits and model."""
    if state.tendon_age != 0:
        return state
    odd = state.mode in WATCHED and bool(_odd_report(setup, state))
    if not odd and not state.bad_cycles.odd_reports:
        return state
    run = state.bad_cycles.odd_reports + state.tendon_interval if odd else 0
    return changed(state, bad_cycles=changed(state.bad_cycles, odd_reports=run))


def _odd_report(setup: CycleSetup, state: CycleState) -> str:
    """Describe the report that cannot be right, or must not be; empty if there is none."""
    bounds, report = setup.tracking_bounds, state.tendon_state
    if report is None or len(report.tension) != len(state.tension_estimate):
        return ""
    for index, (load, model) in enumerate(zip(report.tension, state.tension_estimate.tolist(), strict=True)):
        if load > bounds.load_max:
            tension_max = setup.config.limits.tension_max
            return f"tendon {index} reports {load:.0f} N, where limits.tension_max is {tension_max:g} N"
        if load > 2.0 * model + bounds.load_excess:
            return f"tendon {index} reports {load:.0f} N, where the model has {model:.0f} N"
    for index, displacement in enumerate(report.displacement):
        if not bounds.displacement_min <= displacement <= bounds.displacement_max:
            return f"tendon {index} reports {displacement * 1e3:.0f} mm, far beyond limits.displacement_min and _max"
    return ""


def watch_jumps(setup: CycleSetup, state: CycleState, fresh: bool, innovation: Array) -> JumpWatch:
    """Return the watch of jumps; `fresh`: with a new pose, and its `innovation` [m]."""
    if state.mode not in WATCHED or state.pose is None or state.previous_position is None:
        return JumpWatch() if state.jump_watch != JumpWatch() else state.jump_watch
    if not fresh:
        return state.jump_watch
    if state.bad_cycles.missed_ticks:  # the model stood still while the arm went on: that is no jump of the pose
        return JumpWatch(gap_cycles=state.pose_interval)
    x, y, z = state.previous_position.tolist()
    distance = math.dist(state.pose.position, (x, y, z))
    change = float(np.linalg.norm(innovation - state.observer.innovation))
    return watch_jump(setup.tracking_bounds, state.jump_watch, state.pose_interval, distance, change, (x, y, z))


def watch_tip(setup: CycleSetup, state: CycleState, fresh: bool, reference: ReferencePoint) -> CycleState:
    """Return the state with the tip against its reference, while the rig tracks."""
    if state.mode is not Mode.TRACKING or state.pose is None:
        return changed(state, tracking_watch=TrackingWatch()) if state.tracking_watch != TrackingWatch() else state
    if not fresh or state.jump_watch.withheld:
        return state
    held = setup.observer.kind != "offset" and setup.config.commissioning.orientation < math.pi
    angle = tip_angle(state.pose.orientation, quaternion(state.tip.rotation)) if held else None
    return changed(
        state,
        tracking_watch=watch_tracking(
            setup.tracking_bounds, state.tracking_watch, state.tick, state.pose_interval, state.pose.position,
            reference.position, reference.velocity, state.tension_command.tolist(), angle,
        ),
    )  # fmt: skip


def monitored_fault(setup: CycleSetup, state: CycleState) -> str:
    """Return the reason of these watches to end pretension or tracking; empty if there is none."""
    bounds = setup.tracking_bounds
    if old := pose_age_objection(setup, state, bounds.pose_age_time):
        return f"pose age: {old}"
    if state.bad_cycles.odd_reports >= bounds.report_time and (odd := _odd_report(setup, state)):
        return f"tendon report: {odd}; is its servo's calibration right, or does something hold the arm?"
    if state.jump_watch.persistent:
        return (
            f"pose jump: the measured tip went {state.jump_watch.step_size * 1e3:.0f} mm between two poses and rests "
            "there, which no arm does; was the camera, the base or a marker moved?"
        )
    return tracking_fault(bounds, state.tracking_watch, saturated=state.bad_cycles.limited > 0)
