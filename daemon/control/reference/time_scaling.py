"""Time scaling along a path: a smooth start and end, slowed to what servos and tendons can do."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.reference.path import RestPath
from tendond.daemon.control.servos import pulling_rates
from tendond.model.tendons.allocation import Allocation
from tendond.model.tendons.servo import ServoDynamics

Array = NDArray[np.float64]

MARGIN = 0.85
"""Fraction of a limit that a trajectory may ask for: the rest is for the law. Chosen; `pytest
tests/unit/reference/test_spatial.py` passes with it."""

SLOWDOWN_MAX = 50.0
"""Largest factor by which a trajectory is slowed; one that needs more is refused. Chosen: it only tells
from a slow trajectory one that the limits allow at no speed."""

BEYOND = 0.01
"""Distance from the feasible moments, of the largest one, that is tolerated at their edge: a thousand
times that by which `Allocation` keeps off it (`EDGE`). Chosen."""

SAMPLES_PER_UNIT = 40
"""Samples at which the limits are checked, per unit of a path's parameter: 40 a turn or a second. Chosen."""

Progress = Callable[[float], tuple[float, float, float]]
"""Time [s] to the place on a path, with two derivatives by time; data, so that another process can be sent one."""


@dataclass(frozen=True)
class Timing:
    """Progress along a path.

    Attributes:
        progress: time [s] to the place on the path, with two derivatives by time.
        end: time at which it comes to rest [s].
        slowed: factor by which it takes longer than asked for.
    """

    progress: Progress
    end: float
    slowed: float


@dataclass(frozen=True)
class _MinimumJerk:
    length: float
    duration: float

    def __call__(self, time: float) -> tuple[float, float, float]:
        length, duration = self.length, self.duration
        t = min(max(time / duration, 0.0), 1.0)
        return (
            length * t**3 * (10.0 - 15.0 * t + 6.0 * t * t),
            length * 30.0 * t * t * (1.0 - t) ** 2 / duration,
            length * 60.0 * t * (1.0 - t) * (1.0 - 2.0 * t) / duration**2,
        )


@dataclass(frozen=True)
class _Steady:
    length: float
    ramp: float
    top: float
    end: float

    def __call__(self, time: float) -> tuple[float, float, float]:
        time = min(max(time, 0.0), self.end)
        if time <= 0.5 * self.end:
            return self._half(time)
        place, speed, acceleration = self._half(self.end - time)
        return self.length - place, speed, -acceleration

    def _half(self, time: float) -> tuple[float, float, float]:
        ramp, top = self.ramp, self.top
        t = min(time / ramp, 1.0)
        place = top * ramp * (t**3 - 0.5 * t**4) + top * max(0.0, time - ramp)
        return place, top * t * t * (3.0 - 2.0 * t), top * 6.0 * t * (1.0 - t) / ramp


@dataclass(frozen=True)
class _AsGiven:
    end: float

    def __call__(self, time: float) -> tuple[float, float, float]:
        return (time, 1.0, 0.0) if time < self.end else (self.end, 0.0, 0.0)


@dataclass(frozen=True)
class _Slower:
    progress: Progress
    factor: float

    def __call__(self, time: float) -> tuple[float, float, float]:
        place, speed, acceleration = self.progress(time / self.factor)
        return place, speed / self.factor, acceleration / self.factor**2


def minimum_jerk(length: float, duration: float) -> Timing:
    """Time a path from 0 to `length` (Flash & Hogan 1985): 10 t^3 - 15 t^4 + 6 t^5 of the normalised time."""
    return Timing(_MinimumJerk(length, duration), duration, 1.0)


def steady(length: float, period: float) -> Timing:
    """Time a path from 0 to `length` at one unit per `period`, with half a period of speeding up and of slowing down.

    The speed rises as 3 t^2 - 2 t^3, so that the acceleration has no jump.
    """
    ramp = 0.5 * period
    end = length * period + ramp
    return Timing(_Steady(length, ramp, 1.0 / period, end), end, 1.0)


def as_given(end: float) -> Timing:
    """Time a path whose parameter is time [s] itself."""
    return Timing(_AsGiven(end), end, 1.0)


def slower(timing: Timing, factor: float) -> Timing:
    """Return the timing with `factor` times its duration."""
    return Timing(_Slower(timing.progress, factor), timing.end * factor, timing.slowed * factor)


def slow_down(
    timing: Timing,
    path: RestPath,
    allocation: Allocation,
    rate: float,
    relaxation: float,
    servo: ServoDynamics | None = None,
) -> tuple[Timing, str]:
    """Return the timing, slowed as far as the limits require, and the name of the limit; empty if none.

    Args:
        timing: timing asked for.
        path: path along which it runs.
        allocation: bounds of the tensions.
        rate: displacement rate allowed [m/s].
        relaxation: time constant of the rod's damping, Bbt / EI [s]: a rod that is bent at a rate M' takes a moment
            M + relaxation M'.
        servo: whose loads leave it less than the rate; none: no load does.
    """
    times = np.linspace(0.0, timing.end, max(100, math.ceil(SAMPLES_PER_UNIT * path.length)))
    at = [(path.at(place), speed) for place, speed, _ in map(timing.progress, times)]
    moments = np.array([value[0][path.MOMENT] for value, _ in at])
    rates = np.array([value[1][path.MOMENT] * speed for value, speed in at])
    wanted = np.array([value[1][path.DISPLACEMENT] * speed for value, speed in at])
    by_rate = float(np.max(np.abs(wanted))) / (MARGIN * rate)
    by_load = _slowed_by_load(servo, wanted, [allocation.tensions(one) for one in moments])

    tolerance = BEYOND * float(np.max(np.abs(allocation.corners)))

    def holds(slowed: float) -> bool:
        needed = moments + rates * relaxation / (MARGIN * slowed)
        return all(math.dist(moment, allocation.nearest(moment)) <= tolerance for moment in needed)

    by_tension = 1.0
    if not holds(1.0):
        low, high = 1.0, SLOWDOWN_MAX
        while high - low > 0.01 * low:
            middle = math.sqrt(low * high)
            low, high = (low, middle) if holds(middle) else (middle, high)
        by_tension = high
    slowed = max(1.0, by_rate, by_tension, by_load)
    if slowed == 1.0:
        return timing, ""
    cause = "limits.displacement_rate" if by_rate >= by_tension else "limits.tension_max"
    if by_load == slowed:
        cause = "the load of the servos at observer.servo_voltage"
    return slower(timing, slowed), cause


def _slowed_by_load(servo: ServoDynamics | None, rates: Array, tensions: list[Array]) -> float:
    """Return the factor by which servos that pull against these tensions [N] are slower than these rates [m/s]."""
    slowest = 0.0
    for row, pulls in zip(rates, tensions, strict=True):
        able = pulling_rates(servo, pulls)
        if able is not None:
            taken = np.maximum(row, 0.0) / np.maximum(MARGIN * able, np.finfo(float).tiny)
            slowest = max(slowest, float(np.max(taken)))
    return min(slowest, SLOWDOWN_MAX)
