"""The loop's phase against the poses': found, kept, given up; the rate stays the nominal one."""

import random
from itertools import pairwise

import pytest

from tendond.daemon.runtime import pacing
from tendond.daemon.runtime.arrivals import Arrivals
from tendond.daemon.runtime.pacing import Clock, Wake
from tendond.daemon.runtime.phase import SLEW_ACTIVE, SLEW_LOCKED, WINDOW, PhaseLock
from tendond.schemas.messages import TendonCommand, TipPose

PERIOD = 0.01
ARMED = TendonCommand(seq=0, stamp_ns=0, pose_seq=None, displacement=(0.0,), tension=(0.0,), armed=True)


class Camera:
    """A clock and a hub: poses arrive at times drawn beforehand, and nothing else takes time.

    Args:
        period: of the poses [s]. jitter: standard deviation of their arrival [s]. first: arrival of the first one [s].
        late: of one pose in eight, at most [s], as on a loaded machine.
    """

    def __init__(
        self, period: float, jitter: float = 0.0, first: float = 100.0037, seed: int = 0, late: float = 0.0
    ) -> None:
        self.now, self.period, self.jitter, self.late = 100.0, period, jitter, late
        self.last_command: TendonCommand | None = None
        self.next, self.seq, self.draw = first, 0, random.Random(seed)
        self.arrives = first

    def monotonic(self) -> float:
        self.now += 1e-6
        return self.now

    def sleep(self, duration: float) -> None:
        self.now += duration + 5e-6

    def receive(self, arrivals: Arrivals, *, repeating: bool = False) -> Arrivals:
        while self.arrives <= self.now:
            self.seq += 1
            stamp = round((self.next - 0.004) * 1e9)
            arrivals.pose = TipPose(
                seq=self.seq,
                stamp_ns=stamp,
                position=(0.0, 0.0, 0.5),
                orientation=(1.0, 0.0, 0.0, 0.0),
                source="camera",
            )
            self.arrived = self.arrives
            self.next += self.period
            self.arrives = self.next + max(-0.4 * self.period, self.draw.gauss(0.0, self.jitter))
            if self.late and self.draw.random() < 1.0 / 8.0:
                self.arrives += self.draw.uniform(0.3, 1.0) * self.late
        return arrivals


def wakes(
    camera: Camera, monkeypatch: pytest.MonkeyPatch, cycles: int, period: float = PERIOD
) -> list[tuple[Wake, float]]:
    """The cycles, and the age of the newest pose in each [s]."""
    monkeypatch.setattr(pacing, "time", camera)
    clock = Clock(camera, period, phase=PhaseLock(period))
    found = []
    for _ in range(cycles):
        wake = clock.wait()
        found.append((wake, camera.now - camera.arrived if wake.arrivals.pose else float("nan")))
    return found


@pytest.mark.parametrize("first", [100.0005, 100.0037, 100.0094])
@pytest.mark.parametrize(("period", "rate"), [(0.01, 0.01), (0.01, 0.02), (0.001, 0.001)])
def test_a_pose_waits_a_twentieth_of_a_period_once_the_phase_is_found(
    first: float, period: float, rate: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = wakes(Camera(rate, first=first), monkeypatch, 600, period)[400:]
    assert all(wake.locked for wake, _ in found)
    ages = sorted(age for wake, age in found if wake.arrivals.pose)
    assert ages[len(ages) // 2] < 0.05 * period
    assert ages[-1] < 0.2 * period
    assert len(ages) == pytest.approx(len(found) * period / rate, abs=1)


@pytest.mark.parametrize("first", [100.0005, 100.0037, 100.0094])
def test_of_poses_that_come_five_times_in_two_cycles_every_other_is_fresh(
    first: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = wakes(Camera(0.004, first=first), monkeypatch, 600)[400:]
    assert all(wake.locked for wake, _ in found)
    ages = sorted(age for _, age in found)
    assert ages[len(ages) // 2 - 1] < 0.05 * PERIOD
    assert ages[-1] < 0.002 + 0.05 * PERIOD  # half a pose's period: the most that any phase leaves at best


def test_jitter_widens_the_margin_and_hardly_a_pose_is_late(monkeypatch: pytest.MonkeyPatch) -> None:
    found = wakes(Camera(PERIOD, jitter=2e-4), monkeypatch, 2000)[500:]
    assert sum(wake.locked for wake, _ in found) > 0.99 * len(found)
    assert sum(wake.arrivals.pose is None for wake, _ in found) < 0.02 * len(found)
    ages = sorted(age for wake, age in found if wake.arrivals.pose)
    assert ages[len(ages) // 2] < 0.05 * PERIOD


def test_poses_of_which_some_are_late_are_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """A loaded machine delays every eighth pose by 1 to 3 ms: an old one in its place would be a step back."""
    found = wakes(Camera(PERIOD, jitter=1e-4, late=3e-3), monkeypatch, 3000)[1000:]
    assert sum(wake.locked for wake, _ in found) > 0.9 * len(found)
    assert sum(wake.arrivals.pose is None for wake, _ in found) < 0.01 * len(found)
    ages = sorted(age for wake, age in found if wake.arrivals.pose)
    assert ages[len(ages) // 2] < 0.05 * PERIOD


def test_the_rate_stays_nominal_while_tendons_are_taut(monkeypatch: pytest.MonkeyPatch) -> None:
    """A camera whose clock is 80 ppm slow is followed; the mean rate differs by no more than that."""
    camera = Camera(PERIOD * (1.0 + 80e-6), jitter=1e-4)
    camera.last_command = ARMED
    found = [wake for wake, _ in wakes(camera, monkeypatch, 6000)]
    deadlines = [wake.at - wake.lateness for wake in found]
    steps = [b - a for a, b in pairwise(deadlines)]
    assert max(abs(step - PERIOD) for step in steps) <= SLEW_ACTIVE * PERIOD + 1e-9
    locked = [step for step, wake in zip(steps, found[1:], strict=True) if wake.locked][2 * WINDOW :]
    assert len(locked) > 4000
    assert max(abs(step - PERIOD) for step in locked) <= SLEW_LOCKED * PERIOD + 1e-9
    assert abs(sum(locked) / len(locked) / PERIOD - 1.0) < 100e-6


def test_poses_without_a_phase_leave_the_loop_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    found = [wake for wake, _ in wakes(Camera(PERIOD, jitter=0.4 * PERIOD), monkeypatch, 1000)]
    assert not any(wake.locked for wake in found[WINDOW:])
    deadlines = [wake.at - wake.lateness for wake in found]
    assert (deadlines[-1] - deadlines[0]) / (len(deadlines) - 1) == pytest.approx(PERIOD, rel=3e-3)


def test_poses_that_stop_or_jump_are_given_up_and_found_again(monkeypatch: pytest.MonkeyPatch) -> None:
    camera = Camera(PERIOD)
    monkeypatch.setattr(pacing, "time", camera)
    clock = Clock(camera, PERIOD, phase=PhaseLock(PERIOD))
    assert [clock.wait().locked for _ in range(300)][-1]
    camera.next = camera.arrives = camera.now + 1.0 + 0.4 * PERIOD
    free = [clock.wait() for _ in range(50)]
    assert not free[-1].locked
    assert free[-1].at - free[-11].at == pytest.approx(10 * PERIOD, abs=1e-4)
    again = [clock.wait() for _ in range(400)]
    assert again[-1].locked
    assert again[-1].pose_wait is not None
    assert again[-1].pose_wait < 0.05 * PERIOD


def test_no_cycle_is_skipped_or_added_by_the_lock(monkeypatch: pytest.MonkeyPatch) -> None:
    found = [wake for wake, _ in wakes(Camera(PERIOD, jitter=1e-4), monkeypatch, 1000)]
    assert not any(wake.missed_ticks for wake in found)
    starts = [wake.at for wake in found]
    assert min(b - a for a, b in pairwise(starts)) > 0.5 * PERIOD
