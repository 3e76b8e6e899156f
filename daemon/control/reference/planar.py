"""References in the bending plane, checked against what the rod can reach."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from tendond.daemon.control.reference.equilibria import folded_note, plane_objection, rest_at, selected
from tendond.daemon.control.reference.feasibility import feasibility
from tendond.daemon.control.reference.goal import Goal
from tendond.daemon.control.reference.load_offset import LoadOffset, offset_gain
from tendond.daemon.control.reference.strain import strain_note
from tendond.daemon.control.reference.trajectories import CurvePath, DirectPath, SampledPath, Trajectory, progress_of
from tendond.daemon.errors import TargetError
from tendond.model.rod.static_curve import Pair, StaticCurve, static_curve
from tendond.model.rods.interface import ModelRod
from tendond.schemas.base import Vector3
from tendond.schemas.config.control import PLANES as PLANES
from tendond.schemas.config.given import by_default
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.errors.units import unit_hint
from tendond.schemas.paper_robot import TARGET_X
from tendond.schemas.record import ReferencePoint

Array = NDArray[np.float64]

REACHED = 0.002
"""Distance from the curve of resting tips within which a target is reachable, of the rod's length: about the observer's
noise floor, ten standard deviations of a camera's noise."""

PAST_TARGET = 0.5
"""Bend beyond the target from which on the laws' inverse of b_c may have the wrong sign [rad]. With 0.25 a push on an
arm 15 % softer than the model ends in a tracking error (`python -m tests.constants`)."""


@dataclass(frozen=True)
class PlanarReference:
    """A trajectory in the bending plane.

    Attributes:
        target: final position [m].
        arc: arc length of the target on the curve of resting tips [m]; none for samples and for an unreachable target.
        curve: tips of the resting rod without load.
        load_offset: rule by which the along component follows the tip under a load, where it was not asked for.
        trajectory: see `Trajectory`.
        arrival: time from which on the reference rests at its target, or nearly [s].
        notes: remarks for the operator.
        aim: see `Reference`.
    """

    target: Vector3
    arc: float | None
    curve: StaticCurve
    load_offset: LoadOffset | None
    trajectory: Trajectory
    arrival: float
    notes: tuple[str, ...] = ()
    aim: str = "position"

    def past_target(self, tip_direction: Array) -> float | None:
        """Return the tension [N] that holds the target at rest, where the rod is bent past it by `PAST_TARGET`.

        There the laws' inverse of b_c has the wrong sign: they would pull on. None elsewhere, and without a target.

        Args:
            tip_direction: direction of the model's tip, world frame, shape (3,).
        """
        if self.arc is None:
            return None
        across, along = self.curve.axes
        angle = math.atan2(float(tip_direction[across]), float(tip_direction[along]))
        beyond = math.remainder(angle - float(np.interp(self.arc, self.curve.arc, self.curve.angle)), 2.0 * math.pi)
        side = math.copysign(1.0, float(self.curve.angle[-1]))
        return self.curve.tension_at(self.arc) if side * beyond > PAST_TARGET else None

    def at(self, time: float) -> ReferencePoint:
        """Evaluate the trajectory at `time` [s] since tracking began."""
        (x, z), velocity, acceleration = self.trajectory(time)
        axes = self.curve.axes
        return ReferencePoint.trusted(
            position=in_world((x, z), axes),
            velocity=in_world(velocity, axes),
            acceleration=in_world(acceleration, axes),
            target=self.target,
        )

    def goal(self, time: float) -> Goal:
        """Evaluate the goal of a law in space at `time` [s]."""
        return Goal(np.array(self.at(time).position), None)


def in_world(pair: Pair, axes: tuple[int, int]) -> Vector3:
    """Return a vector of the bending plane in the world frame."""
    vector = [0.0, 0.0, 0.0]
    vector[axes[0]], vector[axes[1]] = pair
    return vector[0], vector[1], vector[2]


def plan_in_plane(config: RigConfig, rod: ModelRod, curve: StaticCurve | None = None) -> PlanarReference:
    """Plan the reference that a configuration asks for.

    Args:
        config: configuration of the rig; its reference is in the bending plane.
        rod: the controller's model.
        curve: its resting tips, where they are known already.

    Raises:
        TargetError: the target cannot be reached; the message names the nearest that can.
        ConvergenceError: the rod has no equilibrium.
    """
    section, axes = config.reference, PLANES[config.control.plane]
    if curve is None:
        curve = static_curve(rod, config.control.agonist, config.limits.tension_max, axes)
    if section.kind == "samples":
        trajectory, target, arrival = _sampled(section, curve, REACHED * rod.parameters.length)
        notes = feasibility(curve, trajectory, arrival, target, config.limits)
        return PlanarReference(in_world(target, axes), None, curve, None, trajectory, arrival, notes)
    tolerance, new = REACHED * rod.parameters.length, config.control.rules > 1
    point, arc, folded = _resolve(config, curve, tolerance)
    strained: tuple[str, ...] = ()
    if new and arc is not None:
        state = rest_at(config, rod, curve, arc)
        objection = plane_objection(config, rod, state, axes, tolerance)
        if objection and section.unreachable == "refuse":
            raise TargetError(objection)
        strained = strain_note(config, rod, [state], "at the target")
    across, along = point.tolist()
    progress, arrival = progress_of(section)
    if section.path == "direct" or arc is None:
        trajectory = DirectPath(progress, across, along)
    else:
        start_arc = float(np.interp(config.pretension.tension, curve.tension, curve.arc))
        trajectory = CurvePath(progress, curve, start_arc, arc - start_arc)
    load_offset = None
    if section.target_name == "across":
        gain = offset_gain(curve, arc, config.loop.period) if new and arc is not None else None
        load_offset = LoadOffset(axes, arrival, rod.parameters.length, gain)
    notes = folded + strained + feasibility(curve, trajectory, arrival, (across, along), config.limits)
    return PlanarReference(in_world((across, along), axes), arc, curve, load_offset, trajectory, arrival, notes)


Resolved = tuple[Array, float | None, tuple[str, ...]]
"""Point of a target in the plane [m]; arc length of it, if it is on the curve; remarks for the operator."""


def _resolve(config: RigConfig, curve: StaticCurve, tolerance: float) -> Resolved:
    """Return the target's point in the plane [m], and its arc length where it is on the curve to `tolerance` [m]."""
    section = config.reference
    name = section.target_name
    if name == "position":
        assert section.position is not None
        wanted = np.array([section.position[i] for i in curve.axes])
        arc = float(curve.nearest(wanted)[0])
        at = curve.at(arc)[0]
        if float(np.linalg.norm(at - wanted)) <= tolerance:
            return wanted, arc, ()
        return _unreachable(config, f"position = {list(section.position)}", wanted, at)
    if name == "across":
        value = TARGET_X if section.across is None else section.across
        found = curve.where_across(value)
        default = " (the default)" if section.across is None else ""
        values, asked, unit = curve.spline(curve.arc)[:, 0], f"across = {value}{default}", "m"
    else:
        value = _angle(section, curve)
        found = curve.where_angle(value)
        values, unit = curve.angle, "rad"
        asked = f"angle = {value:g}" if name == "angle" else f"direction, which is an angle of {value:.4f} rad,"
    if found.size:
        index = selected(config, section, found, asked)
        arc = float(found[index])
        papers = config.control.rules == 1 or (name == "across" and section.across is None)  # its own experiment
        return curve.at(arc)[0], arc, () if papers else folded_note(section, curve, found, index, asked)
    nearest = int(np.argmin(np.abs(values - value)))
    point = curve.spline(curve.arc[nearest])
    wanted = np.array([value, point[1]]) if name == "across" else point
    far = name == "across" and abs(value) > config.rod.backbone_length
    hint = unit_hint(value, unit, lambda one: float(values.min()) <= one <= float(values.max())) if far else ""
    return _unreachable(config, asked, wanted, point, f"{values[nearest]:.4f} {unit}", hint)


def _unreachable(
    config: RigConfig, asked: str, wanted: Array, nearest: Array, value: str = "", hint: str = ""
) -> Resolved:
    section = config.reference
    if section.unreachable == "track":
        return wanted, None, ()
    limits, remedy = (
        config.limits,
        "" if section.target_name in section.model_fields_set else "; no target is given: write reference.across",
    )
    at = f"(across, along) = ({nearest[0]:.4f}, {nearest[1]:.4f}) m"
    raise TargetError(
        f"reference.{asked} is beyond what the rod can reach with the agonist up to limits.tension_max = "
        f"{limits.tension_max:g} N{by_default(limits, 'tension_max')}; "
        f"the nearest is {value + ', ' if value else ''}the tip at {at}{hint}{remedy}"
    )


def _angle(section: ReferenceSection, curve: StaticCurve) -> float:
    """Return the bending angle asked for [rad]."""
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


def _sampled(section: ReferenceSection, curve: StaticCurve, tolerance: float) -> tuple[Trajectory, Pair, float]:
    """Return a cubic spline through samples, at rest at both ends; its last point [m]; and its end [s].

    Each sample is checked against the curve, to `tolerance` [m].
    """
    if not section.samples:
        raise TargetError(f"reference.file = '{section.file}' has not been read: give the configuration as a file")
    table = np.array(section.samples)
    if section.unreachable == "refuse":
        arcs = curve.nearest(table[:, 1:])
        gaps = np.linalg.norm(curve.spline(arcs) - table[:, 1:], axis=1)
        worst = int(np.argmax(gaps))
        if gaps[worst] > tolerance:
            near = curve.at(float(arcs[worst]))[0]
            raise TargetError(
                f"reference.samples[{worst}] = {table[worst].tolist()} is {gaps[worst] * 1e3:.1f} mm from where the "
                f"tip can rest; the nearest is (across, along) = ({near[0]:.4f}, {near[1]:.4f}) m, or set "
                "reference.unreachable = 'track'"
            )
    spline = CubicSpline(table[:, 0], table[:, 1:], bc_type="clamped")
    end, last = float(table[-1, 0]), (float(table[-1, 1]), float(table[-1, 2]))
    return SampledPath(spline, end, last), last, end
