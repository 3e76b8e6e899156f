"""The target in motion by hand: its place on the curve of resting tips, its speed, and the bounds of both.

A trapezoidal profile whose wanted speed is streamed: in each cycle the speed changes by no more than the largest
acceleration, and is never more than what stops before the end of the curve's usable part.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from tendond.daemon.control.reference.planar import PlanarReference, in_world
from tendond.model.rod.static_curve import Pair, StaticCurve, point_evaluator
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.teleop import ACCELERATION, SPEED

PROJECTIONS = 3
"""Steps from a sample of the curve to the nearest point of it: each squares the distance, from a millimetre."""

_evaluator = lru_cache(maxsize=4)(point_evaluator)  # its lists take longer than the rest of a cycle of this


@dataclass(frozen=True)
class JogBounds:
    """Bounds of a target that is moved by hand.

    Attributes:
        speed: [m/s]. acceleration: [m/s^2].
        timeout: cycles without a new request after which the wanted speed is zero.
        first, last: arc lengths on the curve of resting tips between which it stays [m]. end: of the curve [m].
    """

    speed: float
    acceleration: float
    timeout: int
    first: float
    last: float
    end: float

    @staticmethod
    def of(config: RigConfig, curve: StaticCurve, tension_max: float) -> "JogBounds":
        """Return the bounds of a configuration on a curve, with the largest tension in use [N]."""
        section, length = config.teleop, config.rod.backbone_length
        usable = max(section.tension_part * tension_max, config.pretension.tension)
        first, last = np.interp([config.pretension.tension, usable], curve.tension, curve.arc).tolist()
        return JogBounds(
            speed=SPEED * length if section.speed_max is None else section.speed_max,
            acceleration=ACCELERATION * length if section.acceleration_max is None else section.acceleration_max,
            timeout=max(1, round(section.timeout / config.loop.period)),
            first=first,
            last=last,
            end=curve.length,
        )


@dataclass(frozen=True)
class Jog:
    """Motion of a target that is moved by hand.

    Attributes:
        arc: place on the curve of resting tips [m].
        speed: along it, positive away from the straight rod [m/s]. acceleration: [m/s^2].
        wanted: speed asked for last [m/s]; left: cycles for which it still counts.
        held: arc length at which the target rested last [m].
    """

    arc: float
    speed: float
    acceleration: float
    wanted: float
    left: int
    held: float

    def ask(self, wanted: float, bounds: JogBounds) -> "Jog":
        """Return the motion with another speed wanted [m/s]."""
        return replace(self, wanted=min(bounds.speed, max(-bounds.speed, wanted)), left=bounds.timeout)

    def advance(self, bounds: JogBounds, period: float) -> "Jog":
        """Return the motion a cycle of `period` [s] later."""
        wanted = self.wanted if self.left > 0 else 0.0
        step = bounds.acceleration * period
        # A target that is beyond the usable part, where a limit was lowered, may only go back.
        ahead = _stopping_speed(bounds.last - self.arc, self.speed, step, period)
        back = _stopping_speed(self.arc - bounds.first, -self.speed, step, period)
        speed = min(self.speed + step, max(self.speed - step, min(ahead, max(-back, wanted))))
        arc = self.arc + 0.5 * period * (self.speed + speed)
        if speed > 0.0 and self.arc < bounds.last <= arc:
            arc, speed = bounds.last, 0.0
        elif speed < 0.0 and self.arc > bounds.first >= arc:
            arc, speed = bounds.first, 0.0
        arc = min(max(arc, 0.0), bounds.end)
        return replace(
            self,
            arc=arc,
            speed=speed,
            acceleration=(speed - self.speed) / period,
            left=max(0, self.left - 1),
            held=arc if speed == 0.0 else self.held,
        )


def _stopping_speed(distance: float, speed: float, step: float, period: float) -> float:
    """Return the largest speed after a cycle [m/s] with which the target can still stop within a distance.

    The cycle itself takes h (v0 + v) / 2 and the braking v^2 / 2a: v is the root of v^2 + a h v + a h v0 - 2 a d.

    Args:
        distance: d [m]; below zero: beyond the end. speed: v0, towards the end [m/s].
        step: a h, the largest change of the speed in a cycle [m/s]. period: h [s].
    """
    root = step * step - 4.0 * step * speed + 8.0 * step / period * distance
    return max(0.0, 0.5 * (math.sqrt(root) - step)) if root > 0.0 else 0.0


class JogPath:
    """Path of a target that is moved by hand, as it would go on: along the curve at its speed, to the bounds.

    Args:
        curve: tips of the resting rod. jog: the motion at the time `now` [s]. bounds: where it stays.
    """

    def __init__(self, curve: StaticCurve, jog: Jog, bounds: JogBounds, now: float) -> None:
        self._point_at, self._jog, self._now = _evaluator(curve.spline), jog, now
        self._low, self._high = min(bounds.first, jog.arc), max(bounds.last, jog.arc)

    def __call__(self, time: float) -> tuple[Pair, Pair, Pair]:
        """Evaluate at `time` [s] since tracking began."""
        jog, ahead = self._jog, time - self._now
        speed, push = jog.speed, jog.acceleration if ahead == 0.0 else 0.0
        arc = min(max(jog.arc + speed * ahead, self._low), self._high)
        p, (a, b), (c, d) = self._point_at(arc)
        bend = speed * speed
        return p, (a * speed, b * speed), (c * bend + a * push, d * bend + b * push)


def start_jog(reference: PlanarReference, time: float, tolerance: float) -> Jog | None:
    """Return the motion that goes on from where a reference is at `time` [s]; none where it is beside the curve.

    Args:
        reference: in the bending plane. time: since tracking began [s].
        tolerance: largest distance from the curve of resting tips [m].
    """
    curve = reference.curve
    (x, z), (vx, vz), _ = reference.trajectory(time)
    arc = float(curve.nearest(np.array([x, z]))[0])
    point_at = _evaluator(curve.spline)
    for _ in range(PROJECTIONS):  # what is nearest so far is one of the curve's samples
        (cx, cz), (tx, tz), _ = point_at(arc)
        arc += (x - cx) * tx + (z - cz) * tz
    (cx, cz), (tx, tz), _ = point_at(arc)
    if math.hypot(cx - x, cz - z) > tolerance:
        return None
    return Jog(arc=arc, speed=vx * tx + vz * tz, acceleration=0.0, wanted=0.0, left=0, held=arc)


def moved_reference(reference: PlanarReference, jog: Jog, bounds: JogBounds, time: float) -> PlanarReference:
    """Return the reference that is moved by hand, from `time` [s] on; its target is where it rested last."""
    curve = reference.curve
    target = in_world(_evaluator(curve.spline)(jog.held)[0], curve.axes)
    path = JogPath(curve, jog, bounds, time)
    return replace(reference, target=target, arc=jog.arc, load_offset=None, trajectory=path, arrival=time)
