"""A reference in space: a course that is moved to where the tip can rest, and slowed to what the servos can do."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.reference.path import Way
from tendond.daemon.control.reference.shapes import sampled, shape_of
from tendond.daemon.control.reference.time_scaling import SLOWEST, Timing, as_given, minimum_jerk, slow_down, steady
from tendond.daemon.control.reference.workspace import Rest, Surface
from tendond.daemon.errors import TargetError
from tendond.model.errors import ConvergenceError
from tendond.model.rod.rod import Rod
from tendond.model.tendons.allocation import Allocation
from tendond.schemas.base import Vector3
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.record import ReferencePoint

Array = NDArray[np.float64]

PER_TURN = 48
"""Equilibria of a turn: a spline through them is within a micrometre of a circle of 0.3 m."""

PER_SECOND, MOST_SAMPLES = 20.0, 2000
"""Equilibria of a course of samples."""

LEAD_IN = 17
"""Equilibria from the pretension to a course's beginning."""

TOLD = 1e-4
"""[m] A course that is moved by less is not said to be."""


@dataclass(frozen=True)
class Goal:
    """What a law that looks ahead is to reach.

    Attributes:
        place: position [m] or direction [-] of the tip, shape (3,).
        answer: of it, in the resting rod, to the tendons' bending moment, shape (3, 2); none where that is not known.
    """

    place: Array
    answer: Array | None


@dataclass(frozen=True)
class Course:
    """A reference in space, a stretch after the other; the members of `reference.Reference` that the cycle asks for.

    Attributes:
        aim: 'position' or 'direction': what the goal is of.
        stretches: ways, and the progress along each.
        target: where the tip is at the end [m].
        moved: by how much the course was moved at most [m], or [rad].
        notes: what was changed of it, for people.
        yields: false: what loads make of the shape is the law's to know; see `reference.Reference`.
    """

    aim: str
    stretches: tuple[tuple[Way, Timing], ...]
    target: Vector3
    moved: float
    notes: tuple[str, ...]
    yields: bool = False

    @property
    def arrival(self) -> float:
        """Time from which on it rests [s]."""
        return sum(timing.end for _, timing in self.stretches)

    @property
    def lead_in(self) -> float:
        """Time at which the course itself begins [s]; before it, the tip is led there."""
        return self.stretches[0][1].end if len(self.stretches) > 1 else 0.0

    def overbent(self, tip_direction: Array) -> None:
        """None: the sensitivities know how the rod is bent; see `reference.Reference.overbent`."""

    def at(self, time: float, slip: float = 0.0) -> ReferencePoint:
        """The tip's place at `time` [s] since tracking began; `slip` is for references in the plane."""
        way, (place, speed, acceleration) = self._locate(time)
        value, first, second = (one[way.POSITION] for one in way.at(place))
        rows = np.array([value, first * speed, second * speed**2 + first * acceleration]).tolist()
        return ReferencePoint.trusted(
            position=tuple(rows[0]), velocity=tuple(rows[1]), acceleration=tuple(rows[2]), target=self.target
        )

    def goal(self, time: float, slip: float = 0.0) -> Goal:
        """What is to be reached at `time` [s]; `slip` is for references in the plane."""
        way, (place, _, _) = self._locate(time)
        value = way.value(place)
        if self.aim == "direction":
            return Goal(value[way.DIRECTION], value[way.DIRECTION_ANSWER].reshape(3, 2))
        return Goal(value[way.POSITION], value[way.POSITION_ANSWER].reshape(3, 2))

    def _locate(self, time: float) -> tuple[Way, tuple[float, float, float]]:
        for way, timing in self.stretches[:-1]:
            if time < timing.end:
                return way, timing.progress(time)
            time -= timing.end
        way, timing = self.stretches[-1]
        return way, timing.progress(time)


def build_course(config: RigConfig, rod: Rod, allocation: Allocation) -> Course:
    """The course that a configuration's [reference] asks for.

    Args:
        config: of the rig; its reference is in space.
        rod: the controller's model.
        allocation: of its tendons.

    Raises:
        TargetError: it is further from where the tip can rest than `moved_max`, or too fast for the limits.
    """
    section, surface = config.reference, Surface(rod, allocation)
    wanted, length, timing = _wanted(section)
    try:
        start = surface.rest(allocation.moment(np.full(allocation.arms.shape[1], allocation.tension_min)))
        rests, moved = _moved(section, surface, wanted)
        lead = [start]
        for part in np.linspace(0.0, 1.0, LEAD_IN)[1:-1]:
            lead.append(surface.rest(start.moment + part * (rests[0].moment - start.moment), lead[-1]))
    except ConvergenceError as error:
        raise TargetError(f"reference.kind = '{section.kind}': the rod cannot rest where it leads: {error}") from error
    elastic = config.rod.tendon_stiffness is not None
    asked = [(Way(surface, [*lead, rests[0]], 1.0, elastic=elastic), minimum_jerk(1.0, section.duration))]
    if timing is not None:
        asked.append((Way(surface, rests, length, elastic=elastic), timing))
    unit = "m" if section.aim == "position" and section.direction is None else "rad"
    notes = []
    if moved > TOLD:
        notes.append(f"the course was moved by up to {moved:.4f} {unit}, to where the tip can rest")
    relaxation = rod.parameters.bending_damping[0] / rod.parameters.bending_stiffness
    stretches = []
    for (way, given), name in zip(asked, ("the way to the course", "the course"), strict=False):
        slowed, cause = slow_down(given, way, allocation, config.limits.displacement_rate, relaxation)
        if slowed.slowed >= SLOWEST:
            raise TargetError(f"reference.kind = '{section.kind}': {cause} allows it at no speed")
        if cause:
            notes.append(f"{name} takes {slowed.slowed:.2f} times as long as asked for, because of {cause}")
        stretches.append((way, slowed))
    x, y, z = rests[-1].place[:3].tolist()
    aim = "direction" if section.direction is not None else section.aim
    return Course(aim, tuple(stretches), (x, y, z), moved, tuple(notes))


def _wanted(section: ReferenceSection) -> tuple[list[Array], float, Timing | None]:
    """Places in a row, the parameter of the last one, and the timing; none for a single place."""
    if section.kind == "point":
        if section.direction is None:
            return [np.array(section.position)], 0.0, None
        size = math.hypot(*section.direction)
        if size == 0.0:
            raise TargetError("reference.direction = [0, 0, 0] is no direction")
        return [np.array(section.direction) / size], 0.0, None
    if section.kind == "samples":
        spline, end = sampled(section)
        count = min(max(len(section.samples), math.ceil(end * PER_SECOND) + 1), MOST_SAMPLES)
        return [spline(time) for time in np.linspace(0.0, end, count)], end, as_given(end)
    shape = shape_of(section)
    turns = np.linspace(0.0, section.laps, PER_TURN * section.laps + 1)
    return [shape(float(turn)) for turn in turns], float(section.laps), steady(section.laps, section.period)


def _moved(section: ReferenceSection, surface: Surface, wanted: Sequence[Array]) -> tuple[list[Rest], float]:
    """The equilibria nearest to the wanted places, and the largest distance."""
    rests: list[Rest] = []
    furthest, aim = 0.0, "direction" if section.direction is not None else section.aim
    for place in wanted:
        rest, missing = surface.find(place, aim, far=section.branch == "far", start=rests[-1] if rests else None)
        apart = math.hypot(*missing.tolist())
        if apart > section.moved_max:
            there = rest.seen(aim, len(place))[0]
            unit = "m" if aim == "position" else "rad"
            raise TargetError(
                f"reference.kind = '{section.kind}' leads to {_numbers(place)}, {apart:.3f} {unit} from where the tip "
                f"can rest, which is {_numbers(there)}: more than reference.moved_max = {section.moved_max:g}; draw it "
                "smaller or elsewhere"
            )
        furthest = max(furthest, apart)
        rests.append(rest)
    return rests, furthest


def _numbers(place: Array) -> str:
    return "(" + ", ".join(f"{value:.4f}" for value in place) + ")"
