"""Swings while tracking: one that goes on is a limit cycle, one that dies down or follows the reference is none."""

import math
from collections.abc import Callable

import pytest

from tendond.daemon.control.commissioning.swing import Swing
from tendond.daemon.control.commissioning.tracking import TrackingBounds, TrackingWatch, tracking_fault, watch_tracking
from tendond.schemas.base import Vector3
from tendond.schemas.config.rig import RigConfig

BOUNDS = TrackingBounds.from_config(RigConfig())


def test_a_swing_that_goes_on_is_found_with_its_size_and_frequency() -> None:
    swing = Swing()
    for tick in range(600):
        swing = swing.add(0.05 * math.sin(2.0 * math.pi * 2.0 * 0.01 * tick), tick, BOUNDS.swing)
    found = swing.sustained(0.01)
    assert found is not None
    assert found[0] == pytest.approx(0.1, rel=0.01)
    assert found[1] == pytest.approx(2.0, rel=0.05)


@pytest.mark.parametrize("ratio", [0.03, 0.16])
def test_a_swing_that_dies_down_or_is_small_is_none(ratio: float) -> None:
    dying, small = Swing(), Swing()
    for tick in range(2000):
        phase = 2.0 * math.pi * 1.0 * 0.01 * tick
        dying = dying.add(0.1 * math.exp(-ratio * phase) * math.cos(phase), tick, BOUNDS.swing)
        small = small.add(0.4 * BOUNDS.swing * math.cos(phase), tick, BOUNDS.swing)
        assert dying.sustained(0.01) is None
        assert small.sustained(0.01) is None


def test_swings_with_a_rest_between_them_are_no_limit_cycle() -> None:
    """A start that rings six times, five seconds of rest, and a push that makes the arm ring again."""
    swing = Swing()
    for tick in range(1400):
        now = 0.01 * tick
        ringing = now < 3.0 or now > 8.0
        value = 0.1 * math.exp(-0.1 * (now if now < 3.0 else now - 8.0)) * math.cos(2.0 * math.pi * 1.1 * now)
        swing = swing.add(value if ringing else 0.0, tick, BOUNDS.swing)
        if now < 12.0:
            assert swing.sustained(0.01) is None
    assert swing.sustained(0.01) is not None  # the second ringing alone has lasted long enough by now


def test_a_swing_that_dies_down_and_is_pushed_again_is_no_limit_cycle_and_a_growing_one_is() -> None:
    pushed, growing = Swing(), Swing()
    for tick in range(900):
        now = 0.01 * tick
        since = now % 3.5  # a push each 3.5 s, of which a tenth is left when the next one comes
        pushed = pushed.add(0.1 * math.exp(-0.65 * since) * math.cos(2.0 * math.pi * 2.0 * since), tick, BOUNDS.swing)
        growing = growing.add(0.02 * math.exp(0.3 * now) * math.cos(2.0 * math.pi * 2.0 * now), tick, BOUNDS.swing)
        assert pushed.sustained(0.01) is None, (tick, pushed)
        if now > 4.5:
            assert growing.sustained(0.01) is not None, (tick, growing)


def swung(position: Callable[[float], float], velocity: Callable[[float], Vector3], seconds: float) -> str:
    """Watch a tip that is off its reference in x [m], while that moves [m/s]."""
    watch, still = TrackingWatch(), (0.0, 0.0, 0.0)
    for tick in range(round(seconds / 0.01)):
        now = 0.01 * tick
        tip = (position(now), 0.0, 0.0)
        watch = watch_tracking(BOUNDS, watch, tick, 1, tip, still, velocity(now), (0.0,) * 4, 0.0)
        if found := tracking_fault(BOUNDS, watch, saturated=False):
            return found
    return ""


def test_a_tip_that_swings_as_its_reference_does_is_not_the_loops_fault() -> None:
    """A chirp that the tip follows late, and a reference that starts and stops twice in a second."""

    def sway(now: float) -> float:
        return 0.04 * math.sin(2.0 * math.pi * 2.0 * now)

    def back_and_forth(now: float) -> Vector3:
        return (0.3 * math.cos(2.0 * math.pi * 2.0 * now), 0.0, 0.0)

    def steps(now: float) -> Vector3:
        return (0.1 if now % 1.0 < 0.4 else 0.0, 0.0, 0.0)

    assert swung(sway, back_and_forth, 20.0) == ""
    assert swung(sway, steps, 20.0) == ""


@pytest.mark.parametrize("turning", [0.0, 0.3])
def test_a_swing_about_a_reference_that_rests_or_goes_round_is_a_limit_cycle(turning: float) -> None:
    def round_and_round(now: float) -> Vector3:
        angle = 2.0 * math.pi * 0.3 * now
        return (turning * math.cos(angle), turning * math.sin(angle), 0.0)

    found = swung(lambda now: 0.04 * math.sin(2.0 * math.pi * 2.0 * now), round_and_round, 5.0)
    assert found.startswith("limit cycle: the tip swings by 80 mm in x at 2.0 Hz")
