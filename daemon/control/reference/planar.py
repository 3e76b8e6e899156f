"""Where the tip should be, as a function of the time since tracking began; checked against what the rod can reach."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from tendond.daemon.control.reference.spatial import Goal
from tendond.daemon.errors import TargetError
from tendond.model.rod.rod import Rod
from tendond.model.rod.static_curve import Pair, StaticCurve, point_evaluator, static_curve
from tendond.schemas.base import Vector3
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.record import ReferencePoint

Array = NDArray[np.float64]

PLANES = {"xz": (0, 2), "yz": (1, 2)}
"""World axes of a bending plane: across the straight rod, and along it."""

REACHED = 1e-3
"""[m] A target this near to the curve of resting tips is reachable."""

OVERBENT = 0.5
"""[rad]"""

PAPER_ACROSS = 0.34
"""[m] Target where the configuration names none: the paper's x."""

SETTLED_COURSE = 0.999
"""Part of the way from which on the along component of a target 'across' lets itself be moved by loads."""


Progress = Callable[[float], tuple[float, float, float]]
"""Part of the way against time, with two derivatives."""

Course = Callable[[float], tuple[Pair, Pair, Pair]]
"""Time [s] to position, velocity, acceleration [m, m/s, m/s^2] in the plane; data, as all that a reference holds."""


@dataclass(frozen=True)
class _Step:
    def __call__(self, time: float) -> tuple[float, float, float]:
        return 1.0, 0.0, 0.0


@dataclass(frozen=True)
class _Exponential:
    rate: float

    def __call__(self, time: float) -> tuple[float, float, float]:
        rate = self.rate
        rest = math.exp(-rate * time)
        return 1.0 - rest, rate * rest, -(rate**2) * rest


@dataclass(frozen=True)
class _MinimumJerk:
    """Flash & Hogan 1985: 10 t^3 - 15 t^4 + 6 t^5 of the normalised time."""

    duration: float

    def __call__(self, time: float) -> tuple[float, float, float]:
        duration = self.duration
        t = min(time / duration, 1.0)
        return (
            t**3 * (10.0 - 15.0 * t + 6.0 * t**2),
            30.0 * t**2 * (1.0 - t) ** 2 / duration,
            60.0 * t * (1.0 - t) * (1.0 - 2.0 * t) / duration**2,
        )


@dataclass(frozen=True)
class _Direct:
    """Across from zero, along at its target at once."""

    progress: Progress
    across: float
    along: float

    def __call__(self, time: float) -> tuple[Pair, Pair, Pair]:
        f, f1, f2 = self.progress(time)
        return (f * self.across, self.along), (f1 * self.across, 0.0), (f2 * self.across, 0.0)


class _Along:
    """Along the curve of resting tips, from one arc of it by a length."""

    def __init__(self, progress: Progress, curve: StaticCurve, start: float, way: float) -> None:
        self._made_of = (progress, curve, start, way)
        self._progress, self._start, self._way = progress, start, way
        self._point_at, self._end = point_evaluator(curve.spline), curve.length

    def __reduce__(self) -> tuple[type["_Along"], tuple[Progress, StaticCurve, float, float]]:
        return _Along, self._made_of

    def __call__(self, time: float) -> tuple[Pair, Pair, Pair]:
        f, f1, f2 = self._progress(time)
        way = self._way
        p, (a, b), (c, d) = self._point_at(min(max(self._start + f * way, 0.0), self._end))
        speed, bend, push = f1 * way, (f1 * way) ** 2, f2 * way
        return p, (a * speed, b * speed), (c * bend + a * push, d * bend + b * push)


class _Sampled:
    """Through samples, and at rest after the last."""

    def __init__(self, spline: CubicSpline, end: float, last: Pair) -> None:
        self._made_of = (spline, end, last)
        self._point_at, self._end, self._last = point_evaluator(spline), end, last

    def __reduce__(self) -> tuple[type["_Sampled"], tuple[CubicSpline, float, Pair]]:
        return _Sampled, self._made_of

    def __call__(self, time: float) -> tuple[Pair, Pair, Pair]:
        if time >= self._end:
            return self._last, (0.0, 0.0), (0.0, 0.0)
        return self._point_at(time)


@dataclass(frozen=True)
class Reference:
    """A course in time.

    Attributes:
        target: where it ends [m].
        arc: of the target along the curve of resting tips [m]; none for samples and for an unreachable target.
        curve: of resting tips, of the rod without load.
        yields: the along component is not part of what was asked, and may follow the tip under load.
        course: time [s] to position, velocity, acceleration [m, m/s, m/s^2] in the plane, each across and along.
        arrival: time from which on the reference rests at its target, or nearly [s].
        notes, aim: as those of a `Course`.
    """

    target: Vector3
    arc: float | None
    curve: StaticCurve
    yields: bool
    course: Course
    arrival: float
    notes: tuple[str, ...] = ()
    aim: str = "position"

    def overbent(self, tip_direction: Array) -> float | None:
        """Tension [N] that holds the target at rest, where the rod is bent beyond the target by more than `OVERBENT`.

        There the laws' inverse of b_c points the wrong way: they would pull on. None elsewhere, and without a target.

        Args:
            tip_direction: of the model, world frame, shape (3,).
        """
        if self.arc is None:
            return None
        across, along = self.curve.axes
        angle = math.atan2(float(tip_direction[across]), float(tip_direction[along]))
        beyond = math.remainder(angle - float(np.interp(self.arc, self.curve.arc, self.curve.angle)), 2.0 * math.pi)
        side = math.copysign(1.0, float(self.curve.angle[-1]))
        return self.curve.tension_at(self.arc) if side * beyond > OVERBENT else None

    def at(self, time: float, slip: float = 0.0) -> ReferencePoint:
        """The point at `time` [s] since tracking began, its along component moved by `slip` [m]."""
        (x, z), velocity, acceleration = self.course(time)
        axes = self.curve.axes
        return ReferencePoint.trusted(
            position=in_world((x, z + slip), axes),
            velocity=in_world(velocity, axes),
            acceleration=in_world(acceleration, axes),
            target=self.target,
        )

    def goal(self, time: float, slip: float = 0.0) -> Goal:
        """What a law that looks ahead is to reach at `time` [s]."""
        return Goal(np.array(self.at(time, slip).position), None)


def in_world(pair: Pair, axes: tuple[int, int]) -> Vector3:
    """A vector of the bending plane in the world frame."""
    vector = [0.0, 0.0, 0.0]
    vector[axes[0]], vector[axes[1]] = pair
    return vector[0], vector[1], vector[2]


def build_reference(config: RigConfig, rod: Rod, curve: StaticCurve | None = None) -> Reference:
    """The reference that a configuration asks for.

    Args:
        config: of the rig.
        rod: the controller's model.
        curve: of its resting tips, where it is known already.

    Raises:
        TargetError: the target cannot be reached; the message names the nearest that can.
        ConvergenceError: the rod has no equilibrium.
    """
    section, axes = config.reference, PLANES[config.control.plane]
    if curve is None:
        curve = static_curve(rod, config.control.agonist, config.limits.tension_max, axes)
    if section.kind == "samples":
        return _sampled(section, curve)
    point, arc = _resolve(section, curve)
    across, along = point.tolist()
    progress, arrival = _progress(section)
    course: Course
    if section.path == "direct" or arc is None:
        course = _Direct(progress, across, along)
    else:
        start_arc = float(np.interp(config.pretension.tension, curve.tension, curve.arc))
        course = _Along(progress, curve, start_arc, arc - start_arc)
    yields = section.target_name == "across"
    return Reference(in_world((across, along), axes), arc, curve, yields, course, arrival)


def _resolve(section: ReferenceSection, curve: StaticCurve) -> tuple[Array, float | None]:
    """The target's point in the plane [m], and its arc on the curve, if it has one."""
    name = section.target_name
    if name == "position":
        assert section.position is not None
        wanted = np.array([section.position[i] for i in curve.axes])
        arc = float(curve.nearest(wanted)[0])
        at = curve.at(arc)[0]
        if float(np.linalg.norm(at - wanted)) <= REACHED:
            return wanted, arc
        return _unreachable(section, f"position = {list(section.position)}", wanted, at)
    if name == "across":
        value = PAPER_ACROSS if section.across is None else section.across
        found = curve.where_across(value)
        values, asked, unit = curve.spline(curve.arc)[:, 0], f"across = {value}", "m"
    else:
        value = _angle(section, curve)
        found = curve.where_angle(value)
        values, unit = curve.angle, "rad"
        asked = f"angle = {value:g}" if name == "angle" else f"direction, which is an angle of {value:.4f} rad,"
    if found.size:
        arc = float(found[-1] if section.branch != "near" else found[0])
        return curve.at(arc)[0], arc
    nearest = int(np.argmin(np.abs(values - value)))
    point = curve.spline(curve.arc[nearest])
    wanted = np.array([value, point[1]]) if name == "across" else point
    return _unreachable(section, asked, wanted, point, f"{values[nearest]:.4f} {unit}")


def _unreachable(
    section: ReferenceSection, asked: str, wanted: Array, nearest: Array, value: str = ""
) -> tuple[Array, float | None]:
    if section.unreachable == "track":
        return wanted, None
    at = f"(across, along) = ({nearest[0]:.4f}, {nearest[1]:.4f}) m"
    raise TargetError(
        f"reference.{asked} is beyond what the rod can reach with the agonist up to limits.tension_max; "
        f"the nearest is {value + ', ' if value else ''}the tip at {at}"
    )


def _angle(section: ReferenceSection, curve: StaticCurve) -> float:
    """The bending angle asked for [rad]."""
    if section.angle is not None:
        return section.angle
    assert section.direction is not None
    inside = np.array([section.direction[i] for i in curve.axes])
    size = float(np.linalg.norm(section.direction))
    if size == 0.0 or float(np.linalg.norm(inside)) < 0.999 * size:
        raise TargetError(
            f"reference.direction = {list(section.direction)} must lie in the bending plane and not be zero"
        )
    angle = math.atan2(inside[0], inside[1])
    # Directions repeat every turn: the one nearest to the angles that the rod passes is meant.
    return angle + 2.0 * math.pi * round((0.5 * float(curve.angle[-1]) - angle) / (2.0 * math.pi))


def _progress(section: ReferenceSection) -> tuple[Progress, float]:
    """Part of the way against time, with two derivatives; and the time of arrival [s]."""
    if section.kind == "step":
        return _Step(), 0.0
    if section.kind == "exponential":
        return _Exponential(section.rate), -math.log(1.0 - SETTLED_COURSE) / section.rate
    return _MinimumJerk(section.duration), section.duration


def _sampled(section: ReferenceSection, curve: StaticCurve) -> Reference:
    """A reference through samples: a cubic spline, at rest at both ends, each sample checked against the curve."""
    if not section.samples:
        raise TargetError(f"reference.file = '{section.file}' has not been read: give the configuration as a file")
    table = np.array(section.samples)
    if section.unreachable == "refuse":
        arcs = curve.nearest(table[:, 1:])
        gaps = np.linalg.norm(curve.spline(arcs) - table[:, 1:], axis=1)
        worst = int(np.argmax(gaps))
        if gaps[worst] > REACHED:
            near = curve.at(float(arcs[worst]))[0]
            raise TargetError(
                f"reference.samples[{worst}] = {table[worst].tolist()} is {gaps[worst] * 1e3:.1f} mm from where the "
                f"tip can rest; the nearest is (across, along) = ({near[0]:.4f}, {near[1]:.4f}) m, or set "
                "reference.unreachable = 'track'"
            )
    spline = CubicSpline(table[:, 0], table[:, 1:], bc_type="clamped")
    end, last = float(table[-1, 0]), (float(table[-1, 1]), float(table[-1, 2]))
    return Reference(in_world(last, curve.axes), None, curve, False, _Sampled(spline, end, last), end)
