"""What is watched while active, number by number: each bound, what it is measured against, and what the fault says."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tendond.daemon.control.commissioning.jump import BEFORE_AND_AFTER, POSES_AFTER, JumpWatch, watch_jump
from tendond.daemon.control.commissioning.swing import DYING, MEMORY, SWINGS, Swing
from tendond.daemon.control.commissioning.tracking import (
    MOVING,
    REST_SPEED,
    TrackingBounds,
    TrackingWatch,
    tip_angle,
    tracking_fault,
    watch_tracking,
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
TEXT = """
[loop]
period = 0.02
[rod]
length = 0.4
[limits]
tension_max = 50.0
displacement_min = -0.03
displacement_max = 0.05
[observer]
delay = 0.03
[faults]
tracking_error = 0.15
tracking_time = 1.0
swing = 0.02
tension_swing = 0.1
orientation = 0.7
orientation_time = 0.5
jump = 0.03
load_margin = 0.4
report_time = 0.1
pose_age = 0.06
age_time = 0.3
"""


def test_the_bounds_are_parts_of_length_and_limits_and_times_in_cycles() -> None:
    bounds = TrackingBounds.from_config(parse_config(TEXT, "test"))
    expected = TrackingBounds(
        period=0.02, length=0.4, error=0.06, error_time=50, swing=0.008, tension_swing=5.0, orientation=0.7,
        orientation_time=25, jump=0.012, load_max=70.0, load_excess=20.0, displacement_min=-0.05,
        displacement_max=0.07, report_time=5, pose_age_max=0.09, pose_age_time=15,
    )  # fmt: skip
    for name, value in vars(expected).items():
        assert getattr(bounds, name) == pytest.approx(value), name
    short = parse_config("[faults]\nreport_time = 1e-6\n", "test")
    assert TrackingBounds.from_config(short).report_time == 1


def watched(
    watch: TrackingWatch = TrackingWatch(),  # noqa: B008  frozen
    tip: Vector3 = STILL,
    velocity: Vector3 = STILL,
    angle: float | None = None,
    interval: int = 1,
    commanded: tuple[float, ...] = (0.0,),
    tick: int = 0,
) -> TrackingWatch:
    return watch_tracking(BOUNDS, watch, tick, interval, tip, STILL, velocity, commanded, angle)


def test_an_error_counts_the_cycles_since_the_pose_before_and_ends_with_the_first_small_one() -> None:
    beyond, within = (0.0, 0.6 * BOUNDS.error, 0.9 * BOUNDS.error), (0.0, 0.99 * BOUNDS.error, 0.0)
    once = watched(tip=beyond, interval=3)
    twice = watched(once, tip=beyond, interval=2)
    assert (once.error_cycles, twice.error_cycles) == (3, 5)
    assert once.error == pytest.approx(math.hypot(0.6, 0.9) * BOUNDS.error)
    assert watched(twice, tip=within).error_cycles == 0
    assert watched(tip=(BOUNDS.error, 0.0, 0.0)).error_cycles == 0  # as much as is allowed


def test_a_moving_reference_may_be_further_from_the_tip_and_its_command_may_move() -> None:
    fast, slow = (0.0, 1.01 * REST_SPEED * BOUNDS.length, 0.0), (0.0, 0.99 * REST_SPEED * BOUNDS.length, 0.0)
    tip = (0.0, 0.0, 0.95 * MOVING * BOUNDS.error)
    assert watched(tip=tip, velocity=fast).error_cycles == 0
    assert watched(tip=tip, velocity=slow).error_cycles == 1
    assert watched(tip=(0.0, 0.0, 1.05 * MOVING * BOUNDS.error), velocity=fast).error_cycles == 1
    moving, resting = watched(velocity=fast), watched(velocity=slow, commanded=(1.0, 2.0))
    assert (moving.heading, moving.tension_swings) == (fast, ())
    assert resting.heading == STILL
    assert [swing.extreme for swing in resting.tension_swings] == [1.0, 2.0]
    assert [swing.extreme for swing in moving.tip_swings] == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_swings_are_forgotten_where_the_reference_starts_stops_or_turns_back_and_only_there(axis: int) -> None:
    old = (Swing(True, 1.0, ((0, 0.5),)),) * 3
    ahead = tuple((0.1 * np.eye(3)[axis]).tolist())
    back, aside = tuple(-x for x in ahead), tuple((0.1 * np.eye(3)[axis - 1]).tolist())
    for before, now, kept in (
        (ahead, ahead, True), (ahead, aside, True), (STILL, STILL, True),
        (ahead, back, False), (ahead, STILL, False), (STILL, ahead, False),
    ):  # fmt: skip
        watch = watched(TrackingWatch(tip_swings=old, heading=before), velocity=now, tip=(2.0, 2.0, 2.0))
        assert [bool(swing.reversals) for swing in watch.tip_swings] == [kept] * 3


def test_an_angle_counts_while_it_is_larger_than_allowed_and_none_counts_as_nothing() -> None:
    run = watched(angle=1.01 * BOUNDS.orientation, interval=4)
    assert (run.orientation_cycles, run.angle) == (4, 1.01 * BOUNDS.orientation)
    assert watched(run, angle=1.01 * BOUNDS.orientation, interval=2).orientation_cycles == 6
    assert watched(run, angle=BOUNDS.orientation).orientation_cycles == 0
    none = watched(run)
    assert (none.orientation_cycles, none.angle) == (0, 0.0)


def swing(sizes: list[float], gap: int) -> Swing:
    """Reversals `gap` cycles apart with these sizes between them."""
    value, sign, reversals = 0.0, 1.0, [(0, 0.0)]
    for k, size in enumerate(sizes, 1):
        value, sign = value + sign * size, -sign
        reversals.append((k * gap, value))
    return Swing(reversals=tuple(reversals))


def test_a_swing_is_sustained_by_its_count_its_frequency_and_its_last_two_sizes() -> None:
    found = swing([0.02] * SWINGS, 25).sustained(0.01)  # twelve half periods of 0.25 s
    assert found == pytest.approx((0.02, 2.0))
    assert swing([0.02] * (SWINGS - 1), 25).sustained(0.01) is None
    assert swing([0.02] * SWINGS, 124).sustained(0.01) == pytest.approx((0.02, 0.5 / 1.24))
    assert swing([0.02] * SWINGS, 126).sustained(0.01) is None  # slower than 0.4 Hz
    for last in (-1, -2):
        sizes = [0.02] * SWINGS
        sizes[last] = 1.01 * DYING * 0.02
        assert swing(sizes, 25).sustained(0.01) is not None
        sizes[last] = 0.99 * DYING * 0.02
        assert swing(sizes, 25).sustained(0.01) is None
    sizes = [0.02] * SWINGS
    sizes[-3] = 0.001
    assert swing(sizes, 25).sustained(0.01) is not None


def test_a_fast_swing_is_sustained_once_it_has_lasted_a_second_or_filled_the_memory() -> None:
    assert swing([0.02] * 32, 3).sustained(0.01) is None  # 0.96 s
    assert swing([0.02] * 34, 3).sustained(0.01) == pytest.approx((0.02, 50.0 / 3.0))
    dying = [0.02 * 0.97**k for k in range(34)]  # to 0.37 of it in a second, to 0.71 in twelve half periods
    assert swing(dying, 3).sustained(0.01) is None
    assert swing([0.02] * (MEMORY - 2), 1).sustained(0.01) is None
    assert swing([0.02] * (MEMORY - 1), 1).sustained(0.01) == pytest.approx((0.02, 50.0))


def test_a_reversal_is_a_turn_by_the_hysteresis_and_the_newest_are_kept() -> None:
    up = Swing().add(1.0, 3, 0.5)
    assert (up.up, up.extreme, up.reversals) == (True, 1.0, ())
    assert up.add(0.51, 4, 0.5) == up
    down = up.add(0.5, 4, 0.5)
    assert (down.up, down.extreme, down.reversals) == (False, 0.5, ((4, 1.0),))
    assert down.add(0.4, 5, 0.5).extreme == 0.4
    assert down.add(0.9, 5, 0.5) == down
    again = down.add(1.1, 6, 0.5)
    assert (again.up, again.reversals) == (True, ((4, 1.0), (6, 0.5)))
    one = Swing()
    for tick in range(90):
        one = one.add(float(tick % 2), tick, 0.5)
    assert len(one.reversals) == MEMORY
    assert one.reversals[-1][0] == 89


def test_what_ends_tracking_is_said_with_its_size_its_time_and_what_to_do() -> None:
    error = TrackingWatch(error_cycles=BOUNDS.error_time, error=0.123)
    assert tracking_fault(BOUNDS, error, saturated=False) == (
        "tracking error: the tip is 123 mm from its reference for 1.5 s, and the commands have been there for long; "
        "is the arm held, or the rig another than configured?"
    )
    assert "and the command is at a limit; is" in tracking_fault(BOUNDS, error, saturated=True)
    assert not tracking_fault(BOUNDS, replace(error, error_cycles=BOUNDS.error_time - 1), saturated=True)
    turned = TrackingWatch(orientation_cycles=BOUNDS.orientation_time, angle=math.radians(40.0))
    assert tracking_fault(BOUNDS, turned, saturated=False) == (
        "orientation: the measured tip is turned by 40 degrees against the model's in the same place, for 1 s; "
        "have markers or camera moved?"
    )
    assert not tracking_fault(BOUNDS, replace(turned, orientation_cycles=BOUNDS.orientation_time - 1), saturated=False)
    remedy = "and does not settle; lower observer.integral, or set observer.delay and rod.tip_mass"
    swinging = swing([0.02] * SWINGS, 25)
    for axis, name in enumerate("xyz"):
        tip = tuple(swinging if k == axis else Swing() for k in range(3))
        assert tracking_fault(BOUNDS, TrackingWatch(tip_swings=tip), saturated=False) == (
            f"limit cycle: the tip swings by 20 mm in {name} at 2.0 Hz {remedy}"
        )
    tension = (Swing(), swing([7.5] * SWINGS, 25))
    assert tracking_fault(BOUNDS, TrackingWatch(tension_swings=tension), saturated=False) == (
        f"limit cycle: the command of tendon 1 swings by 7.5 N at 2.0 Hz {remedy}"
    )


def test_a_step_is_a_jump_by_the_tip_and_by_the_model_and_only_from_rest() -> None:
    place, beyond, within = (0.1, 0.0, 0.4), 1.01 * BOUNDS.jump, 0.99 * BOUNDS.jump
    assert watch_jump(BOUNDS, JumpWatch(), 1, beyond, beyond, place).origin == place
    assert watch_jump(BOUNDS, JumpWatch(), 1, within, beyond, place).origin is None
    assert watch_jump(BOUNDS, JumpWatch(), 1, beyond, within, place).origin is None  # the model went as well
    assert watch_jump(BOUNDS, JumpWatch(), 2, beyond, beyond, place).origin is None  # in twice the time
    assert watch_jump(BOUNDS, JumpWatch(), 2, 2 * beyond, 2 * beyond, place).step_size == pytest.approx(beyond)
    for part, withheld in ((0.99, True), (1.01, False)):
        before = JumpWatch(last_step=part * BEFORE_AND_AFTER * beyond)
        assert watch_jump(BOUNDS, before, 1, beyond, beyond, place).withheld is withheld


def test_a_jump_lasts_once_the_tip_has_rested_there_and_is_believed_again_if_it_moves() -> None:
    place, size = (0.1, 0.0, 0.4), 0.03
    jumped = watch_jump(BOUNDS, JumpWatch(), 1, size, size, place)
    resting = jumped
    for poses in range(1, POSES_AFTER):
        resting = watch_jump(BOUNDS, resting, 1, 0.29 * size, 9.0, STILL)
        assert (resting.origin, resting.step_size, resting.rested, resting.persistent) == (place, size, poses, False)
    lasting = watch_jump(BOUNDS, resting, 1, 0.29 * size, 9.0, STILL)
    assert (lasting.persistent, lasting.pose_distrusted, lasting.withheld, lasting.step_size) == (
        True,
        True,
        False,
        size,
    )
    moving = watch_jump(BOUNDS, jumped, 1, 0.31 * size, 9.0, STILL)
    assert (moving.persistent, moving.pose_distrusted, moving.withheld) == (False, True, False)
    assert moving.last_step == pytest.approx(0.31 * size)


def test_the_angle_between_orientations_is_that_of_the_turn_whatever_the_sign() -> None:
    one = (1.0, 0.0, 0.0, 0.0)
    for angle in (0.0, 0.3, 2.0):
        other = (math.cos(angle / 2), 0.0, math.sin(angle / 2), 0.0)
        assert tip_angle(one, other) == pytest.approx(angle, abs=1e-7)
        assert tip_angle(one, tuple(-x for x in other)) == pytest.approx(angle, abs=1e-7)  # type: ignore[arg-type]
    assert tip_angle((1.0000001, 0.0, 0.0, 0.0), one) == 0.0


def aged(state: CycleState, lag: float | None, stamp: int, fresh: bool = True) -> CycleState:
    seen = pose(1).model_copy(update={"stamp_ns": stamp})
    return watch_pose_age(SETUP, state, CycleInputs(pose=seen, pose_lag=lag), fresh)


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
    told = {"tension": (0.0, 10.0, 0.0, 0.0), "displacement": (0.0,) * 4} | change
    report = TendonState(seq=1, stamp_ns=0, **told)
    tension = np.array([0.0, 10.0, 0.0, 0.0])
    state = changed(START, mode=mode, tension_estimate=tension, tendon_state=report, tendon_age=age, tendon_interval=2)
    return watch_reports(SETUP, state)


def test_reports_are_odd_beyond_limits_and_beyond_twice_the_model_while_active() -> None:
    most, apart = BOUNDS.load_max, BOUNDS.load_excess
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
    assert most == pytest.approx(60.0 * (1.0 + CONFIG.faults.load_margin))
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
    moved = replace(START.observer, innovation=START.observer.innovation + np.array([0.0, 0.018, 0.024]))
    seen = watch_jumps(SETUP, state, True, moved)
    assert seen.origin == (x, y, z)
    assert seen.step_size == pytest.approx(0.03)
    assert watch_jumps(SETUP, state, True, START.observer).origin is None  # the model went there, too
    assert watch_jumps(SETUP, state, False, moved) is state.jump_watch
    missed = changed(state, bad_cycles=changed(state.bad_cycles, missed_ticks=5), pose_interval=6)
    assert watch_jumps(SETUP, missed, True, moved) == JumpWatch(gap_cycles=6)
    for idle in (changed(state, mode=Mode.IDLE, jump_watch=seen), changed(state, pose=None, jump_watch=seen)):
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
        told = TendonState(seq=1, stamp_ns=0, tension=(0.0, load, 0.0, 0.0), displacement=(0.0,) * 4)
        state = changed(
            START, mode=Mode.TRACKING, tension_estimate=np.array([0.0, 60.0, 0.0, 0.0]), tendon_state=told,
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
