"""References in space: a trajectory, moved to where the tip can rest and slowed to what the servos can do."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.reference.goal import Goal
from tendond.daemon.control.reference.path import RestPath
from tendond.daemon.control.reference.shapes import sampled, shape_of
from tendond.daemon.control.reference.strain import strain_note
from tendond.daemon.control.reference.stretches import Stretches
from tendond.daemon.control.reference.time_scaling import (
    SLOWDOWN_MAX,
    Timing,
    as_given,
    minimum_jerk,
    slow_down,
    steady,
)
from tendond.daemon.control.reference.workspace import Surface, WorkspaceRest
from tendond.daemon.control.servos import configured_servo
from tendond.daemon.errors import TargetError
from tendond.model.errors import ConvergenceError
from tendond.model.rods.friction import without_friction
from tendond.model.rods.interface import ModelRod
from tendond.model.tendons.allocation import Allocation
from tendond.schemas.base import Vector3
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.record import ReferencePoint

Array = NDArray[np.float64]

PER_TURN = 48
"""Equilibria of a turn: a spline through them is within a micrometre of a circle of 0.3 m."""

PER_SECOND, SAMPLES_MAX = 20.0, 2000
"""Equilibria of a trajectory of samples, per second, and their largest number."""

APPROACH_POINTS = 17
"""Equilibria from the pretension to the beginning of a trajectory."""

MOVED_MIN = {"m": 2e-4, "rad": 1e-4}
"""Distance, of the rod's length, or angle [rad], below which a trajectory that is moved is not said to be: 0.1 mm on
the paper's robot, the last digit of the note. Chosen; it changes the note alone."""


@dataclass(frozen=True)
class SpatialReference(Stretches[RestPath]):
    """A trajectory in space.

    Attributes:
        aim: 'position' or 'direction': the quantity of the goal.
        stretches: paths, and the progress along each.
        target: final position of the tip [m].
        moved: largest distance by which the trajectory was moved [m], or [rad].
        notes: changes made to it, for the operator.
        load_offset: none: every component was asked for.
    """

    aim: str
    stretches: tuple[tuple[RestPath, Timing], ...]
    target: Vector3
    moved: float
    notes: tuple[str, ...]
    load_offset: None = None

    def at(self, time: float) -> ReferencePoint:
        """Evaluate the trajectory at `time` [s] since tracking began."""
        path, (place, speed, acceleration) = self.locate(time)
        value, first, second = (one[path.POSITION] for one in path.at(place))
        return self.passing(value, first, second, speed, acceleration)

    def goal(self, time: float) -> Goal:
        """Evaluate the goal at `time` [s]."""
        path, (place, _, _) = self.locate(time)
        value = path.value(place)
        if self.aim == "direction":
            return Goal(value[path.DIRECTION], value[path.DIRECTION_JACOBIAN].reshape(3, 2))
        return Goal(value[path.POSITION], value[path.POSITION_JACOBIAN].reshape(3, 2))


def plan_in_space(config: RigConfig, rod: ModelRod, allocation: Allocation) -> SpatialReference:
    """Plan the trajectory that a configuration's [reference] asks for.

    Args:
        config: configuration of the rig; its reference is in space.
        rod: the controller's model; its resting tips are taken without friction of the tendons, which leaves the tip
            somewhere around them.
        allocation: map from moments to tensions of its tendons.

    Raises:
        TargetError: it is further from where the tip can rest than `moved_max`, or too fast for the limits.
    """
    section, surface = config.reference, Surface(without_friction(rod), allocation)
    wanted, length, timing = _wanted(section)
    try:
        start = surface.rest(allocation.moment(np.full(allocation.arms.shape[1], allocation.tension_min)))
        rests, moved = _moved(section, surface, wanted)
        approach = [start]
        for part in np.linspace(0.0, 1.0, APPROACH_POINTS)[1:-1]:
            approach.append(surface.rest(start.moment + part * (rests[0].moment - start.moment), approach[-1]))
    except ConvergenceError as error:
        raise TargetError(f"reference.kind = '{section.kind}': the rod cannot rest where it leads: {error}") from error
    elastic = config.rod.has_elastic_tendons
    asked = [(RestPath(surface, [*approach, rests[0]], 1.0, elastic=elastic), minimum_jerk(1.0, section.duration))]
    if timing is not None:
        asked.append((RestPath(surface, rests, length, elastic=elastic), timing))
    unit = "m" if section.aim == "position" and section.direction is None else "rad"
    notes = []
    if moved > MOVED_MIN[unit] * (rod.parameters.length if unit == "m" else 1.0):
        notes.append(f"the trajectory was moved by up to {moved:.4f} {unit}, to where the tip can rest")
    notes += strain_note(config, surface.rod, [one.state for one in (*approach, *rests)], "on the way")
    relaxation = rod.parameters.bending_damping[0] / rod.parameters.bending_stiffness
    stretches = []
    for (path, given), name in zip(asked, ("the approach", "the trajectory"), strict=False):
        rate = config.limits.displacement_rate
        slowed, cause = slow_down(given, path, allocation, rate, relaxation, configured_servo(config))
        if slowed.slowed >= SLOWDOWN_MAX:
            raise TargetError(f"reference.kind = '{section.kind}': {cause} allows it at no speed")
        if cause:
            notes.append(f"{name} takes {slowed.slowed:.2f} times as long as asked for, because of {cause}")
        stretches.append((path, slowed))
    x, y, z = rests[-1].place[:3].tolist()
    aim = "direction" if section.direction is not None else section.aim
    return SpatialReference(aim, tuple(stretches), (x, y, z), moved, tuple(notes))


def _wanted(section: ReferenceSection) -> tuple[list[Array], float, Timing | None]:
    """Return places in a row, the parameter of the last one, and the timing; none for a single place."""
    if section.kind == "point":
        if section.direction is None:
            return [np.array(section.position)], 0.0, None
        size = math.hypot(*section.direction)
        if size == 0.0:
            raise TargetError("reference.direction = [0, 0, 0] is no direction")
        return [np.array(section.direction) / size], 0.0, None
    if section.kind == "samples":
        spline, end = sampled(section)
        count = min(max(len(section.samples), math.ceil(end * PER_SECOND) + 1), SAMPLES_MAX)
        return [spline(time) for time in np.linspace(0.0, end, count)], end, as_given(end)
    shape = shape_of(section)
    turns = np.linspace(0.0, section.laps, PER_TURN * section.laps + 1)
    return [shape(float(turn)) for turn in turns], float(section.laps), steady(section.laps, section.period)


def _moved(section: ReferenceSection, surface: Surface, wanted: Sequence[Array]) -> tuple[list[WorkspaceRest], float]:
    """Return the equilibria nearest to the wanted places, and the largest distance."""
    rests: list[WorkspaceRest] = []
    furthest, aim = 0.0, "direction" if section.direction is not None else section.aim
    above_135 = section.branch == "above_135"
    for place in wanted:
        rest, missing = surface.find(place, aim, above_135=above_135, start=rests[-1] if rests else None)
        apart = math.hypot(*missing.tolist())
        if apart > section.moved_max:
            there = rest.compared(aim, len(place))[0]
            unit = "m" if aim == "position" else "rad"
            raise TargetError(
                f"reference.kind = '{section.kind}' leads to {_numbers(place)}, {apart:.4g} {unit} from where the tip "
                f"can rest, which is {_numbers(there)}: more than reference.moved_max = {section.moved_max:g}; draw it "
                "smaller or elsewhere"
            )
        furthest = max(furthest, apart)
        rests.append(rest)
    return rests, furthest


def _numbers(place: Array) -> str:
    return "(" + ", ".join(f"{value:.4f}" for value in place) + ")"
