"""Timing along a path of poses: the limits hold, and no slower than they ask."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from tendond.daemon.control.pose.path import PosePath
from tendond.daemon.control.pose.timing import PathLimits, time_optimal, within
from tendond.daemon.control.reference.time_scaling import MARGIN, Timing, minimum_jerk

FREE = PathLimits(math.inf, math.inf, math.inf, math.inf, math.inf, 0.02, lambda _: None)


class Line(PosePath):
    """A straight path of 1 m along x, of one tendon, whose displacement and tension go up by 0.1 m and 5 N."""

    def __init__(self) -> None:
        self.length, self.last = 1.0, 8
        self.displacement, self.tension = slice(7, 8), slice(8, 9)
        at = np.linspace(0.0, 1.0, 9)
        rows = np.column_stack((at, 0 * at, 0 * at, 0 * at, 0 * at, 0 * at, 0 * at + 1.0, 0.1 * at, 5.0 * at))
        spline = CubicSpline(at, rows)
        self._step = 1.0 / 8
        self._c3, self._c2, self._c1, self._c0 = np.ascontiguousarray(spline.c)


def motion(timing: Timing) -> tuple[NDArray[np.float64], float]:
    """Place, speed and acceleration at 2001 times, and the time between two [s]."""
    times = np.linspace(0.0, timing.end, 2001)
    return np.array([timing.progress(float(time)) for time in times]), float(times[1])


def test_on_a_line_the_fastest_timing_is_the_trapezoid_of_a_textbook() -> None:
    # Biagiotti & Melchiorri, Trajectory Planning for Automatic Machines, 2008: T = L/v + v/a.
    timing = time_optimal(Line(), replace(FREE, speed=0.5, acceleration=1.0))
    assert timing.end == pytest.approx(1.0 / 0.5 + 0.5 / 1.0 + 0.02, rel=0.03)


@pytest.mark.parametrize(
    ("limits", "speed"),
    [
        (replace(FREE, speed=0.4, acceleration=2.0), 0.4),
        (replace(FREE, displacement_rate=0.05, acceleration=2.0), MARGIN * 0.5),
        (replace(FREE, tension_rate=1.5, acceleration=2.0), MARGIN * 0.3),
    ],
)
def test_the_limits_hold_and_are_used(limits: PathLimits, speed: float) -> None:
    timing, _ = within(time_optimal(Line(), limits), Line(), limits)
    rows, _ = motion(timing)
    assert speed * 0.97 < rows[:, 1].max() < speed * 1.01
    assert np.abs(rows[:, 2]).max() < 2.0 * 1.05
    assert rows[0, 0] == pytest.approx(0.0, abs=1e-9)
    assert rows[-1].tolist() == [1.0, 0.0, 0.0]


def test_the_jerk_is_bounded_and_a_window_is_at_rest_at_both_ends() -> None:
    limits = replace(FREE, speed=0.5, acceleration=1.0, window=0.3, jerk=4.0)
    timing, _ = within(time_optimal(Line(), limits), Line(), limits)
    rows, step = motion(timing)
    assert np.abs(np.diff(rows[:, 2]) / step).max() < 4.0 * 1.15
    assert np.abs(rows[[0, -1], 1]).max() < 1e-3


def test_a_given_timing_is_slowed_to_the_limit_and_its_name_is_told() -> None:
    asked = minimum_jerk(1.0, 1.0)
    timing, cause = within(asked, Line(), replace(FREE, tension_rate=5.0))
    assert cause == "limits.tension_rate"
    assert timing.slowed == pytest.approx(1.875 / MARGIN, rel=0.01)
    assert within(asked, Line(), FREE) == (asked, "")
