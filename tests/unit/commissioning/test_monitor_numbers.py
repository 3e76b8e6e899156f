"""Watched tracking, number by number: each bound, what it is measured against, and what the fault says."""

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
from tendond.schemas.base import Vector3
from tendond.schemas.config.rig import parse_config
from tests.unit.control.cycles import CONFIG

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
        w, x, y, z = other
        assert tip_angle(one, (-w, -x, -y, -z)) == pytest.approx(angle, abs=1e-7)
    assert tip_angle((1.0000001, 0.0, 0.0, 0.0), one) == 0.0
