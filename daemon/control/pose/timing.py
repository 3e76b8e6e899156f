"""Timing of a path of poses: as asked for and slowed to the limits, or as fast as they allow, with bounded jerk.

Along a path q(s) every limit is one of s' and s'' (Bobrow, Dubowsky & Gibson, IJRR 4, 1985). The fastest s(t) with

    |d'(s) s'| <= V_d,  |T'(s) s'| <= V_T,  |p'(s) s'| <= v,  |p''(s) s'^2 + p'(s) s''| <= a     (by component)

is found on a grid by a pass backward, for the squares of s' from which one can still stop, and one forward, greedy
(Pham & Pham, TOPP-RA, IEEE T-RO 34, 2018; x = s'^2, u = s'', x(k+1) = x(k) + 2 u ds). Its acceleration jumps. The mean
of s over a window then bounds the jerk, and a window of the period of the first mode cancels that mode (Singhose,
input shaping). It may cut a limit of another place by a little: what remains beyond one slows the whole trajectory.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from tendond.daemon.control.pose.path import POSITION, PosePath
from tendond.daemon.control.reference.time_scaling import MARGIN, Timing, slower

Array = NDArray[np.float64]

GRID, PER_PIECE, BISECTIONS = 240, 5, 40
"""Least number of places on a path at which the limits hold, and that on each of its pieces; halvings in the search for
the largest x at each. Chosen."""

SAMPLES, SAMPLES_PER_PLACE = 600, 2.5
"""Times at which a timing is checked, and knots of one that is made: least number, and for each place. Chosen."""

PLACES_MAX = 20_000
"""Largest number of places: 80 turns, which are planned in seconds."""


@dataclass(frozen=True)
class PathLimits:
    """Limits along a path.

    Attributes:
        displacement_rate: of every tendon [m/s]. tension_rate: of every tendon's tension [N/s].
        speed: of the tip [m/s]. acceleration: of the tip, by component [m/s^2]. jerk: likewise [m/s^3].
        window: over which a time-optimal motion is averaged [s].
        pulling: from tensions [N], shape (n,), to the rates at which servos pull against them [m/s], shape (n,).
    """

    displacement_rate: float
    tension_rate: float
    speed: float
    acceleration: float
    jerk: float
    window: float
    pulling: Callable[[Array], Array | None]


@dataclass(frozen=True)
class _Sampled:
    """Progress by a spline through samples against time."""

    spline: CubicSpline
    end: float
    length: float

    def __call__(self, time: float) -> tuple[float, float, float]:
        if time >= self.end:
            return self.length, 0.0, 0.0
        inside = max(time, 0.0)
        return float(self.spline(inside)), float(self.spline(inside, 1)), float(self.spline(inside, 2))


def within(timing: Timing, path: PosePath, limits: PathLimits) -> tuple[Timing, str]:
    """Return the timing, slowed as far as the limits require, and the name of the limit; empty if none."""
    times = np.linspace(0.0, timing.end, _samples(path))
    places, speeds, accelerations = np.array([timing.progress(time) for time in times.tolist()]).T
    values, firsts, seconds = (np.array(rows) for rows in zip(*(path.at(s) for s in places.tolist()), strict=True))
    rates = firsts[:, path.displacement] * speeds[:, None]
    pulls = np.abs(firsts[:, path.tension] * speeds[:, None])
    tip_speed = np.linalg.norm(firsts[:, POSITION], axis=1) * speeds
    acceleration = seconds[:, POSITION] * speeds[:, None] ** 2 + firsts[:, POSITION] * accelerations[:, None]
    jerk = np.diff(acceleration, axis=0) / max(float(times[1]), 1e-12)
    need = {
        "limits.displacement_rate": _over(rates, MARGIN * limits.displacement_rate),
        "limits.tension_rate": _over(pulls, MARGIN * limits.tension_rate),
        "reference.speed_max": _over(tip_speed, limits.speed),
        "reference.acceleration_max": math.sqrt(_over(acceleration, limits.acceleration)),
        "reference.jerk_max": _over(jerk, limits.jerk) ** (1.0 / 3.0),
        "the load of the servos at observer.servo_voltage": _by_load(limits, values[:, path.tension], rates),
    }
    cause = max(need, key=lambda name: need[name])
    if not need[cause] > 1.0 + 1e-9:
        return timing, ""
    return slower(timing, need[cause]), cause


def time_optimal(path: PosePath, limits: PathLimits) -> Timing:
    """Return the fastest timing within the limits, averaged over the window; `within` is to check it."""
    count = _places(path)
    places = np.linspace(0.0, path.length, count + 1)
    step = float(places[1])
    _, firsts, seconds = (np.array(rows) for rows in zip(*(path.at(s) for s in places.tolist()), strict=True))
    top = _largest_squares(path, firsts, limits)
    first, second = firsts[:, POSITION], seconds[:, POSITION]
    reachable = np.zeros(count + 1)
    for k in range(count - 1, -1, -1):
        low, high = 0.0, float(top[k])
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            u_low, u_high = _pushes(first[k], second[k], middle, limits.acceleration)
            u_low, u_high = max(u_low, -0.5 * middle / step), min(u_high, 0.5 * (reachable[k + 1] - middle) / step)
            low, high = (middle, high) if u_low <= u_high else (low, middle)
        reachable[k] = low
    squares = np.zeros(count + 1)
    for k in range(count):
        _, u = _pushes(first[k], second[k], float(squares[k]), limits.acceleration)
        squares[k + 1] = min(max(squares[k] + 2.0 * u * step, 0.0), reachable[k + 1])
    speeds = np.sqrt(squares)
    times = np.append(0.0, np.cumsum(2.0 * step / np.maximum(speeds[1:] + speeds[:-1], 1e-9)))
    return _averaged(times, places, limits.window, _samples(path))


def _places(path: PosePath) -> int:
    return min(max(GRID, PER_PIECE * path.last), PLACES_MAX)


def _samples(path: PosePath) -> int:
    return max(SAMPLES, round(SAMPLES_PER_PLACE * _places(path)))


def _averaged(times: Array, places: Array, window: float, samples: int) -> Timing:
    """Return the timing with the mean of the places over the window before each time."""
    last, length = float(times[-1]), float(places[-1])
    end = last + window
    fine = np.linspace(0.0, end, samples)
    # The integral of s(t), a spline through its knots, gives the mean without a sum over the window.
    total = CubicSpline(times, places, bc_type="clamped").antiderivative()

    def area(at: Array) -> Array:
        inside = np.clip(at, 0.0, last)
        return np.asarray(total(inside) + length * np.maximum(at - last, 0.0))

    mean = (area(fine) - area(fine - window)) / window
    mean[0], mean[-1] = 0.0, length
    return Timing(_Sampled(CubicSpline(fine, mean, bc_type="clamped"), end, length), end, 1.0)


def _largest_squares(path: PosePath, firsts: Array, limits: PathLimits) -> Array:
    """Return the largest squares of s' by the limits of rates, shape (k,); zero at both ends."""
    slowest = np.full(len(firsts), 1e-12)
    for columns, bound in (
        (path.displacement, MARGIN * limits.displacement_rate),
        (path.tension, MARGIN * limits.tension_rate),
    ):
        slowest = np.maximum(slowest, np.max(np.abs(firsts[:, columns]), axis=1) / bound)
    slowest = np.maximum(slowest, np.linalg.norm(firsts[:, POSITION], axis=1) / limits.speed)
    squares = 1.0 / slowest**2
    squares[0] = squares[-1] = 0.0
    return np.asarray(squares)


def _pushes(first: Array, second: Array, square: float, acceleration: float) -> tuple[float, float]:
    """Return the smallest and the largest s'' at a place for which the tip's acceleration is within its bound."""
    low, high = -math.inf, math.inf
    for slope, bend in zip(first.tolist(), (second * square).tolist(), strict=True):
        if abs(slope) < 1e-9:
            if abs(bend) > acceleration:
                return 1.0, -1.0
            continue
        ends = sorted(((-acceleration - bend) / slope, (acceleration - bend) / slope))
        low, high = max(low, ends[0]), min(high, ends[1])
    return max(low, -1e9), min(high, 1e9)


def _over(values: Array, bound: float) -> float:
    return float(np.max(np.abs(values))) / bound if math.isfinite(bound) else 0.0


def _by_load(limits: PathLimits, tensions: Array, rates: Array) -> float:
    """Return the factor by which servos that pull against these tensions [N] are slower than these rates [m/s]."""
    slowest = 0.0
    for pulls, row in zip(tensions, rates, strict=True):
        able = limits.pulling(pulls)
        if able is not None:  # a load slows no servo that pays out
            slowest = max(
                slowest, float(np.max(np.maximum(row, 0.0) / np.maximum(MARGIN * able, np.finfo(float).tiny)))
            )
    return slowest
