"""Frames of a regular camera have regular times, however late their packets come."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.drivers.mocap.frame_clock import MOST_NS, FrameClock
from tendond.drivers.mocap.frames import NUMBERS

Array = NDArray[np.float64]

SETTLED = 100


def stamped(times: Array, delays: Array, first: int = 0, step: int = 1) -> Array:
    """Errors of the clock's times [s]: frames at `times`, packets `delays` after them."""
    clock = FrameClock()
    numbers = (first + step * np.arange(len(times))) % NUMBERS
    arrivals = np.rint((times + delays) * 1e9).astype(np.int64)
    stamps = [clock.stamp(int(n), int(a)) for n, a in zip(numbers, arrivals, strict=True)]
    assert all(stamp <= arrival for stamp, arrival in zip(stamps, arrivals.tolist(), strict=True))
    return np.asarray(np.array(stamps) * 1e-9 - times)


@pytest.mark.parametrize(("rate", "step", "first"), [(100.0, 1, 0), (330.0, 1, NUMBERS - 500), (100.0, 3, 7)])
def test_packets_that_a_busy_computer_sent_late_have_the_times_of_their_frames(
    rate: float, step: int, first: int
) -> None:
    rng = np.random.default_rng(1)
    times = 1000.0 + np.arange(2000) / rate
    delays = rng.exponential(5e-4, len(times))
    delays[rng.random(len(times)) < 0.03] += 0.015
    errors = stamped(times, delays, first, step)[SETTLED:]
    assert float(np.std(errors)) < 0.3 * float(np.std(delays))
    assert float(np.max(errors)) < 0.006


def test_a_camera_that_is_slower_than_it_was_and_a_network_that_is_are_followed() -> None:
    steps = np.full(3000, 0.01)
    steps[1000:] *= 1.02
    times = 1000.0 + np.cumsum(steps)
    delays = np.zeros(len(times))
    delays[2000:] = 0.005
    errors = stamped(times, delays)
    assert float(np.max(np.abs(errors[:2000]))) < 0.005
    assert errors[-1] == pytest.approx(0.005, abs=2e-4)


@pytest.mark.parametrize("stall", [0.05, 0.1, 0.2])
def test_packets_that_come_at_once_after_a_stall_do_not_change_the_interval(stall: float) -> None:
    times: Array = np.asarray(1000.0 + np.arange(400) * 0.01, dtype=np.float64)
    delays: Array = np.asarray(np.maximum(0.0, times[200] + stall - times), dtype=np.float64)
    delays[:200] = 0.0
    delays = np.asarray(delays + np.arange(400) % 7 * 1e-5, dtype=np.float64)  # tenths of a millisecond in a burst
    errors = stamped(times, delays)
    held = delays > 2e-4
    assert float(np.max(np.abs(errors[~held]))) < 0.003
    assert float(np.min(errors)) > -0.003


def test_a_packet_that_is_overtaken_changes_nothing() -> None:
    clock = FrameClock()
    for n in range(1, 60):
        clock.stamp(n, 10_000_000 * n)
    assert clock.stamp(58, 591_000_000) == pytest.approx(580_000_000, abs=1000)
    assert clock.stamp(60, 600_000_000) == pytest.approx(600_000_000, abs=1000)


def test_frames_lost_duplicates_and_a_restart() -> None:
    clock = FrameClock()
    at = [clock.stamp(n, 10_000_000 * n) for n in range(1, 60)]
    assert at == [10_000_000 * n for n in range(1, 60)]
    assert clock.stamp(59, 590_400_000) == 590_000_000  # the second block of a frame
    assert clock.stamp(75, 757_000_000) == pytest.approx(750_000_000, abs=600_000)
    late = clock.stamp(76, 760_000_000 + 2 * MOST_NS)
    assert late == 760_000_000 + 2 * MOST_NS  # too late to be the frame that it says: it counts as it comes
    assert clock.stamp(3, 10**9) == 10**9
    assert clock.stamp(4, 1_010_000_000) == 1_010_000_000
