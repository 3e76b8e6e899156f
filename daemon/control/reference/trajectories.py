"""Trajectories in the bending plane: the progress along a path against time, and the paths themselves.

All are data, so that another process can be sent one.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from scipy.interpolate import CubicSpline

from tendond.model.rod.static_curve import Pair, StaticCurve, point_evaluator
from tendond.schemas.config.reference import ReferenceSection

ARRIVED = 0.999
"""Fraction of an exponential from which on it counts as arrived."""

Progress = Callable[[float], tuple[float, float, float]]
"""Fraction of the path against time [s], with two derivatives."""

Trajectory = Callable[[float], tuple[Pair, Pair, Pair]]
"""Time [s] to position, velocity, acceleration [m, m/s, m/s^2] in the plane, each across and along the straight rod."""


@dataclass(frozen=True)
class Step:
    """The whole path at once."""

    def __call__(self, time: float) -> tuple[float, float, float]:
        """Evaluate at `time` [s]."""
        return 1.0, 0.0, 0.0


@dataclass(frozen=True)
class Exponential:
    """1 - exp(-rate t); rate [1/s]."""

    rate: float

    def __call__(self, time: float) -> tuple[float, float, float]:
        """Evaluate at `time` [s]."""
        rate = self.rate
        rest = math.exp(-rate * time)
        return 1.0 - rest, rate * rest, -(rate**2) * rest


@dataclass(frozen=True)
class MinimumJerk:
    """10 t^3 - 15 t^4 + 6 t^5 of the normalised time (Flash & Hogan 1985); duration [s]."""

    duration: float

    def __call__(self, time: float) -> tuple[float, float, float]:
        """Evaluate at `time` [s]."""
        duration = self.duration
        t = min(time / duration, 1.0)
        return (
            t**3 * (10.0 - 15.0 * t + 6.0 * t**2),
            30.0 * t**2 * (1.0 - t) ** 2 / duration,
            60.0 * t * (1.0 - t) * (1.0 - 2.0 * t) / duration**2,
        )


def progress_of(section: ReferenceSection) -> tuple[Progress, float]:
    """Return the progress that a section asks for, and the time of arrival [s]."""
    if section.kind == "step":
        return Step(), 0.0
    if section.kind == "exponential":
        return Exponential(section.rate), -math.log(1.0 - ARRIVED) / section.rate
    return MinimumJerk(section.duration), section.duration


@dataclass(frozen=True)
class DirectPath:
    """Across from zero to `across` [m], along at its target `along` [m] at once."""

    progress: Progress
    across: float
    along: float

    def __call__(self, time: float) -> tuple[Pair, Pair, Pair]:
        """Evaluate at `time` [s]."""
        f, f1, f2 = self.progress(time)
        return (f * self.across, self.along), (f1 * self.across, 0.0), (f2 * self.across, 0.0)


class CurvePath:
    """Path along the curve of resting tips, from the arc length `start` [m] by `length` [m]."""

    def __init__(self, progress: Progress, curve: StaticCurve, start: float, length: float) -> None:
        self._made_of = (progress, curve, start, length)
        self._progress, self._start, self._length = progress, start, length
        self._point_at, self._end = point_evaluator(curve.spline), curve.length

    def __reduce__(self) -> tuple[type["CurvePath"], tuple[Progress, StaticCurve, float, float]]:
        return CurvePath, self._made_of

    def __call__(self, time: float) -> tuple[Pair, Pair, Pair]:
        """Evaluate at `time` [s]."""
        f, f1, f2 = self._progress(time)
        length = self._length
        p, (a, b), (c, d) = self._point_at(min(max(self._start + f * length, 0.0), self._end))
        speed, bend, push = f1 * length, (f1 * length) ** 2, f2 * length
        return p, (a * speed, b * speed), (c * bend + a * push, d * bend + b * push)


class SampledPath:
    """A spline through samples against time, at rest after the last one."""

    def __init__(self, spline: CubicSpline, end: float, last: Pair) -> None:
        self._made_of = (spline, end, last)
        self._point_at, self._end, self._last = point_evaluator(spline), end, last

    def __reduce__(self) -> tuple[type["SampledPath"], tuple[CubicSpline, float, Pair]]:
        return SampledPath, self._made_of

    def __call__(self, time: float) -> tuple[Pair, Pair, Pair]:
        """Evaluate at `time` [s]."""
        if time >= self._end:
            return self._last, (0.0, 0.0), (0.0, 0.0)
        return self._point_at(time)
