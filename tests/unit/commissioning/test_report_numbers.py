"""Watched poses and reports, number by number: their age, odd reports, jumps, and which tips are compared."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tendond.daemon.control.commissioning.jump import JumpWatch, watch_jump
from tendond.daemon.control.commissioning.tracking import (
    TrackingBounds,
    TrackingWatch,
)
from tendond.daemon.control.phases.monitors import (
    CLOCK_DRIFT,
    ONE_CLOCK,
    monitored_fault,
    pose_age_objection,
    watch_jumps,
    watch_pose_age,
    watch_reports,
    watch_tip,
)
from tendond.daemon.control.state import CycleState, changed
from tendond.schemas.base import Vector3
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode, TendonState
from tendond.schemas.record import CycleInputs, ReferencePoint
from tests.unit.control.cycles import CONFIG, SETUP, START, pose

STILL: Vector3 = (0.0, 0.0, 0.0)
BOUNDS = TrackingBounds.from_config(CONFIG)


def aged(state: CycleState, lag: float | None, stamp: int, fresh: bool = True) -> CycleState:
    stamped = pose(1).model_copy(update={"stamp_ns": stamp})
    return watch_pose_age(SETUP, state, CycleInputs(pose=stamped, pose_lag=lag), fresh)


def test_the_age_of_a_pose_is_its_lag_on_one_clock_and_its_growth_on_another() -> None:
    start = changed(START, pose_interval=3)
    late = aged(start, 0.08, 5)
    assert (late.stamp_age.seconds, late.stamp_age.too_old, late.stamp_age.stamp_ns, late.stamp_age.lag_min) == (
        0.08,
        3,
        5,
        0.08,
    )
    assert aged(late, 0.07, 6).stamp_age.too_old == 6
    assert aged(late, 0.04, 6).stamp_age.too_old == 0
    assert aged(late, 0.07, 5) is late  # the same pose again
    assert aged(late, 0.07, 6, fresh=False) is late
    assert aged(late, None, 6) is late
    for lag in (ONE_CLOCK, 1000.0, -5.0):
        far = aged(start, lag, 5)
        assert (far.stamp_age.seconds, far.stamp_age.too_old) == (0.0, 0)
        later = aged(far, lag + 0.08, 6)
        drift = CLOCK_DRIFT * 3 * CONFIG.loop.period
        assert later.stamp_age.lag_min == pytest.approx(lag + drift)
        assert later.stamp_age.seconds == pytest.approx(0.08 - drift, abs=1e-9)
        assert later.stamp_age.too_old == 3


def test_old_poses_object_after_their_time_and_say_how_old_they_may_be() -> None:
    state = aged(changed(START, pose_interval=3), 0.08, 5)
    words = "poses are 80 ms old, where observer.delay and faults.pose_age allow 50 ms: find what delays them, or "
    assert pose_age_objection(SETUP, state, 3) == words + "set observer.delay"
    assert pose_age_objection(SETUP, state, 4) == ""
    old = changed(state, stamp_age=changed(state.stamp_age, too_old=BOUNDS.pose_age_time))
    assert monitored_fault(SETUP, old) == f"pose age: {words}set observer.delay"
    assert monitored_fault(SETUP, state) == ""


def reported(mode: Mode = Mode.TRACKING, age: int = 0, **change: tuple[float, ...]) -> CycleState:
    """A state in which the model has 10 N in tendon 1 and the tendons have just reported."""
    values = {"tension": (0.0, 10.0, 0.0, 0.0), "displacement": (0.0,) * 4} | change
    report = TendonState(seq=1, stamp_ns=0, **values)
    tension = np.array([0.0, 10.0, 0.0, 0.0])
    state = changed(START, mode=mode, tension_estimate=tension, tendon_state=report, tendon_age=age, tendon_interval=2)
    return watch_reports(SETUP, state)


def test_reports_are_odd_beyond_limits_and_beyond_twice_the_model_while_active() -> None:
    load_max, apart = BOUNDS.load_max, BOUNDS.load_excess
    low, high = BOUNDS.displacement_min, BOUNDS.displacement_max
    assert reported().bad_cycles.odd_reports == 0
    for bound, change in (
        (20.0 + apart, lambda x: {"tension": (0.0, x, 0.0, 0.0)}),
        (apart, lambda x: {"tension": (0.0, 10.0, 0.0, x)}),
        (high, lambda x: {"displacement": (0.0, 0.0, 0.0, x)}),
        (low, lambda x: {"displacement": (0.0, x, 0.0, 0.0)}),
    ):
        assert reported(**change(bound)).bad_cycles.odd_reports == 0
        assert reported(**change(bound * (1.0 + 1e-9))).bad_cycles.odd_reports == 2
        for mode in (Mode.PRETENSION, Mode.IDLE, Mode.RELEASING, Mode.FAULT):
            assert bool(reported(mode, **change(1.1 * bound)).bad_cycles.odd_reports) is (mode is Mode.PRETENSION)
        assert reported(age=1, **change(1.1 * bound)).bad_cycles.odd_reports == 0
    assert load_max == pytest.approx(60.0 * (1.0 + CONFIG.faults.load_margin))
    assert reported(tension=(0.0, 99.0)).bad_cycles.odd_reports == 0  # of another rig: refused elsewhere


def test_odd_reports_in_a_row_are_a_fault_that_names_the_tendon_and_a_right_one_ends_the_row() -> None:
    odd = reported(tension=(0.0, 10.0, 99.0, 0.0))
    twice = watch_reports(SETUP, odd)
    assert twice.bad_cycles.odd_reports == 4
    long = changed(odd, bad_cycles=changed(odd.bad_cycles, odd_reports=BOUNDS.report_time))
    assert monitored_fault(SETUP, long) == (
        "tendon report: tendon 2 reports 99 N, where limits.tension_max is 60 N; is its servo's calibration right, or "
        "does something hold the arm?"
    )
    almost = changed(odd, bad_cycles=changed(odd.bad_cycles, odd_reports=BOUNDS.report_time - 1))
    assert monitored_fault(SETUP, almost) == ""
    right = changed(long, tendon_state=reported().tendon_state)
    assert watch_reports(SETUP, right).bad_cycles.odd_reports == 0


def test_a_jump_is_of_the_pose_against_the_model_and_none_after_missed_deadlines() -> None:
    assert START.pose is None
    x, y, z = 0.02, 0.0, 0.48
    state = changed(
        START, mode=Mode.TRACKING, pose=pose(2, (x + 0.03, y, z)), previous_position=np.array([x, y, z]),
        pose_interval=1,
    )  # fmt: skip
    still = START.observer.innovation
    moved = still + np.array([0.0, 0.018, 0.024])
    jumped = watch_jumps(SETUP, state, True, moved)
    assert jumped.origin == (x, y, z)
    assert jumped.step_size == pytest.approx(0.03)
    assert watch_jumps(SETUP, state, True, still).origin is None  # the model went there, too
    assert watch_jumps(SETUP, state, False, moved) is state.jump_watch
    missed = changed(state, bad_cycles=changed(state.bad_cycles, missed_ticks=5), pose_interval=6)
    assert watch_jumps(SETUP, missed, True, moved) == JumpWatch(gap_cycles=6)
    for idle in (changed(state, mode=Mode.IDLE, jump_watch=jumped), changed(state, pose=None, jump_watch=jumped)):
        assert watch_jumps(SETUP, idle, True, moved) == JumpWatch()
    lasting = changed(START, jump_watch=JumpWatch(persistent=True, step_size=0.03))
    assert monitored_fault(SETUP, lasting) == (
        "pose jump: the measured tip went 30 mm between two poses and rests there, which no arm does; was the camera, "
        "the base or a marker moved?"
    )


def test_the_tip_is_watched_while_tracking_on_fresh_poses_that_are_believed() -> None:
    far = ReferencePoint(position=(0.3, 0.0, 0.3), velocity=STILL, acceleration=STILL, target=(0.3, 0.0, 0.3))
    state = changed(START, mode=Mode.TRACKING, pose=pose(2), pose_interval=2, tick=7)
    watch = watch_tip(SETUP, state, True, far).tracking_watch
    x, y, z = pose(2).position
    assert watch.error == pytest.approx(math.dist((x, y, z), far.position))
    assert watch.error_cycles == 2
    assert watch.angle == pytest.approx(0.0, abs=1e-6)
    assert watch_tip(SETUP, state, False, far) is state
    withheld = changed(state, jump_watch=JumpWatch(origin=STILL))
    assert watch_tip(SETUP, withheld, True, far) is withheld
    left = changed(state, mode=Mode.RELEASING, tracking_watch=watch)
    assert watch_tip(SETUP, left, True, far).tracking_watch == TrackingWatch()
    limited = changed(START, tracking_watch=TrackingWatch(error_cycles=BOUNDS.error_time, error=0.1))
    assert "the commands have been there" in monitored_fault(SETUP, limited)
    limited = changed(limited, bad_cycles=changed(limited.bad_cycles, limited=1))
    assert "the command is at a limit" in monitored_fault(SETUP, limited)


def test_a_step_that_is_no_jump_is_remembered_as_the_speed_before_the_next() -> None:
    step = 0.9 * BOUNDS.jump
    assert watch_jump(BOUNDS, JumpWatch(), 2, 2.0 * step, 9.0, STILL).last_step == pytest.approx(step)


def test_a_displacement_that_cannot_be_is_said_in_millimetres() -> None:
    odd = reported(displacement=(0.0, 0.0, 0.0, 0.5))
    long = changed(odd, bad_cycles=changed(odd.bad_cycles, odd_reports=BOUNDS.report_time))
    assert monitored_fault(SETUP, long).startswith(
        "tendon report: tendon 3 reports 500 mm, far beyond limits.displacement_min and _max; is its servo's"
    )


def test_a_load_as_large_as_the_largest_is_tolerated_where_the_model_has_as_much() -> None:
    for load, odd in ((BOUNDS.load_max, 0), (BOUNDS.load_max + 1e-9, 2)):
        report = TendonState(seq=1, stamp_ns=0, tension=(0.0, load, 0.0, 0.0), displacement=(0.0,) * 4)
        state = changed(
            START, mode=Mode.TRACKING, tension_estimate=np.array([0.0, 60.0, 0.0, 0.0]), tendon_state=report,
            tendon_age=0, tendon_interval=2,
        )  # fmt: skip
        assert watch_reports(SETUP, state).bad_cycles.odd_reports == odd


@pytest.mark.parametrize(
    ("text", "watched_for"),
    [
        ("", True),
        ('[observer]\nkind = "offset"\n', False),
        (f"[commissioning]\norientation = {math.pi}\n", False),
    ],
)
def test_the_orientation_is_watched_where_the_model_is_held_to_the_tip_and_the_markers_count(
    text: str, watched_for: bool
) -> None:
    setup = replace(SETUP, config=parse_config(text, "test"))
    setup = replace(setup, observer=replace(SETUP.observer, kind=setup.config.observer.kind))
    upright = (1.0, 0.0, 0.0, 0.0)
    state = changed(START, mode=Mode.TRACKING, pose=pose(2, orientation=upright))
    reference = ReferencePoint(position=STILL, velocity=STILL, acceleration=STILL, target=STILL)
    assert bool(watch_tip(setup, state, True, reference).tracking_watch.angle) is watched_for
