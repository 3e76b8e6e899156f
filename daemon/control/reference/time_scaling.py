"""Time along a course: a smooth start and end, and as slow as servos and tendons need it."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.reference.path import Way
from tendond.model.tendons.allocation import Allocation

Array = NDArray[np.float64]

MARGIN = 0.85
"""Of a limit, that a course may ask for: the rest is for the law."""

SLOWEST = 50.0
"""Times slower than asked for: a course that needs more is refused."""

BEYOND = 0.01
"""Of the largest moment, by which a course at the edge of what can be had may be beyond it."""

LOOKS = 40
"""Per unit of a way."""


Progress = Callable[[float], tuple[float, float, float]]
"""Time [s] to the place on a way, with two derivatives by time; data, so that another process can be sent a course."""


@dataclass(frozen=True)
class Timing:
    """Progress along a way.

    Attributes:
        progress: time [s] to the place on the way, with two derivatives by time.
        end: time at which it rests [s].
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
        way, speed, acceleration = self._half(self.end - time)
        return self.length - way, speed, -acceleration

    def _half(self, time: float) -> tuple[float, float, float]:
        ramp, top = self.ramp, self.top
        t = min(time / ramp, 1.0)
        way = top * ramp * (t**3 - 0.5 * t**4) + top * max(0.0, time - ramp)
        return way, top * t * t * (3.0 - 2.0 * t), top * 6.0 * t * (1.0 - t) / ramp


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
    """From 0 to `length` (Flash & Hogan 1985): 10 t^3 - 15 t^4 + 6 t^5 of the normalised time."""
    return Timing(_MinimumJerk(length, duration), duration, 1.0)


def steady(length: float, period: float) -> Timing:
    """From 0 to `length` at one unit per `period`, between half a period of speeding up and one of slowing down.

    The speed rises as 3 t^2 - 2 t^3, so that the acceleration has no jump.
    """
    ramp = 0.5 * period
    end = length * period + ramp
    return Timing(_Steady(length, ramp, 1.0 / period, end), end, 1.0)


def as_given(end: float) -> Timing:
    """The way's parameter is time [s] itself."""
    return Timing(_AsGiven(end), end, 1.0)


def slow_down(timing: Timing, way: Way, allocation: Allocation, rate: float, relaxation: float) -> tuple[Timing, str]:
    """The timing, slowed as far as the limits need it; and which of them it was, empty if none.

    Args:
        timing: as asked for.
        way: that it is along.
        allocation: whose bounds the tensions keep.
        rate: of displacement that is allowed [m/s].
        relaxation: time constant of the rod's damping, Bbt / EI [s]: a rod that is bent at a rate M' takes a moment
            M + relaxation M'.
    """
    times = np.linspace(0.0, timing.end, max(100, math.ceil(LOOKS * way.length)))
    at = [(way.at(place), speed) for place, speed, _ in map(timing.progress, times)]
    moments = np.array([value[0][way.MOMENT] for value, _ in at])
    rates = np.array([value[1][way.MOMENT] * speed for value, speed in at])
    wound = max(float(np.max(np.abs(value[1][way.DISPLACEMENT])) * speed) for value, speed in at)
    by_rate = wound / (MARGIN * rate)

    most = BEYOND * float(np.max(np.abs(allocation.corners)))

    def holds(slowed: float) -> bool:
        needed = moments + rates * relaxation / (MARGIN * slowed)
        return all(math.dist(moment, allocation.nearest(moment)) <= most for moment in needed)

    by_tension = 1.0
    if not holds(1.0):
        low, high = 1.0, SLOWEST
        while high - low > 0.01 * low:
            middle = math.sqrt(low * high)
            low, high = (low, middle) if holds(middle) else (middle, high)
        by_tension = high
    slowed = max(1.0, by_rate, by_tension)
    if slowed == 1.0:
        return timing, ""
    cause = "limits.displacement_rate" if by_rate >= by_tension else "limits.tension_max"
    return Timing(_Slower(timing.progress, slowed), timing.end * slowed, slowed), cause
