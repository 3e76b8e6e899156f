"""Deadlines that have passed: they are counted, and everything that has an age or an interval grows by them."""

import numpy as np
import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import changed, initial_state
from tendond.daemon.runtime import pacing
from tendond.daemon.runtime.arrivals import Arrivals
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode, TendonState
from tendond.schemas.record import CycleInputs
from tests.unit.control.cycles import SETUP, START, armed, follow, pose


@pytest.mark.parametrize("missed", [0, 1, 4])
def test_a_velocity_from_differences_counts_the_deadlines_that_passed_between_two_poses(missed: int) -> None:
    setup = CycleSetup.from_config(parse_config('[control]\nfeedback = "direct"\n', "test"))
    start = initial_state(setup)
    x, y, z = start.tip.position.tolist()
    state, _, _ = step(setup, start, CycleInputs(pose=pose(1, (x, y, z))))
    state = changed(state, mode=Mode.TRACKING)
    further = pose(2, (x + 0.001 * (1 + missed), y, z))
    _, _, record = step(setup, state, CycleInputs(pose=further, missed_ticks=missed))
    assert record.estimate is not None
    assert record.estimate.velocity == pytest.approx((0.1, 0.0, 0.0))


def test_a_pose_that_came_before_missed_deadlines_is_older_by_them() -> None:
    state, _, _ = step(SETUP, START, CycleInputs(pose=pose(1)))
    state, _, record = step(SETUP, state, CycleInputs(missed_ticks=3))
    assert record.pose_age == 4
    _, _, record = step(SETUP, state, CycleInputs())
    assert record.pose_age == 5


def test_tendons_are_stale_after_a_time_of_which_missed_deadlines_are_a_part() -> None:
    allowed, missed = SETUP.thresholds.tendon_timeout, 3
    report = TendonState(seq=1, stamp_ns=0, displacement=(0.0,) * 4, tension=tuple(armed().tension_estimate.tolist()))
    state, _, _ = step(SETUP, armed(), CycleInputs(pose=follow(armed()), tendon_state=report))
    age, late = 0, 0
    while state.mode is Mode.TRACKING:
        late = 0 if late else missed  # never so many in a row that they are a fault themselves
        age += 1 + late
        state, _, record = step(SETUP, state, CycleInputs(pose=follow(state), missed_ticks=late))
        assert age < 2 * allowed
    assert record.reason == f"tendons stale: no state for {age * SETUP.config.loop.period:.2f} s"
    assert allowed < age <= allowed + 1 + missed


class Watch:
    """A clock that moves when somebody sleeps, or when it is set forward."""

    def __init__(self) -> None:
        self.now = 100.0

    def monotonic(self) -> float:
        return self.now

    def sleep(self, duration: float) -> None:
        self.now += duration


class Silence:
    """A hub to which nothing comes."""

    last_command = None

    def receive(self, arrivals: Arrivals, repeating: bool = False) -> Arrivals:
        return arrivals


@pytest.mark.parametrize(
    ("work", "missed"), [(0.0, 0), (0.4, 0), (0.9, 0), (1.1, 1), (1.9, 1), (2.5, 2), (7.2, 7)], ids=str
)
def test_each_deadline_that_passed_before_the_loop_was_ready_is_counted(
    work: float, missed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`work` is what a cycle takes, in periods: the next deadline is the first one after it."""
    watch, period = Watch(), 0.01
    monkeypatch.setattr(pacing, "time", watch)
    clock = pacing.Clock(Silence(), period)
    first = clock.wait()
    assert first.missed_ticks == 0
    assert first.at == pytest.approx(100.0 + period)
    watch.now = first.at + work * period
    second = clock.wait()
    assert second.missed_ticks == missed
    assert second.at == pytest.approx(first.at + (1 + missed) * period)
    assert np.isclose(second.lateness, 0.0, atol=1e-9)
    third = clock.wait()
    assert third.missed_ticks == 0
    assert third.at == pytest.approx(second.at + period)
