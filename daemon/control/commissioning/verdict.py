"""Verdict on the motions of the tip under each tendon: right, or tendons swapped, dead, or too strong."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.schemas.base import Vector3

Array = NDArray[np.float64]

DEAD = 0.25
"""Motion below which a tendon counts as not moving the tip, of the expected motion: half of what a spool of half
the radius leaves. Half and twice of it change no verdict, only its words (`python -m tests.constants DEAD`)."""

FOLLOWING = 0.5, 0.05
"""Part of a commanded displacement, and of the longest arm of a tendon, by which the reported one may differ: of the
arm, 1 mm on the paper's robot. Chosen; it changes no verdict, only the words of one."""

NAMED = 3
"""Largest number of tendons that a verdict names."""


@dataclass(frozen=True)
class Bounds:
    """Bounds of a motion that passes: angle to the expected one [rad], size relative to it [-].

    Attributes:
        angle: [rad]. gain_min, gain_max: [-].
        slack: length by which a reported displacement may differ from half of the commanded one [m].
    """

    angle: float
    gain_min: float
    gain_max: float
    slack: float


@dataclass(frozen=True)
class Motion:
    """Motion of the tip under one tendon.

    Attributes:
        measured, expected: motion from the rest [m].
        commanded, reported: displacement of the tendon [m]; none where the driver reports none.
        first: the same two at a smaller tension, where the motion was looked at twice.
    """

    measured: Vector3
    expected: Vector3
    commanded: float = 0.0
    reported: float | None = None
    first: tuple[Vector3, Vector3] | None = None

    @property
    def size(self) -> float:
        """Measured against expected size [-]."""
        return math.hypot(*self.measured) / max(math.hypot(*self.expected), 1e-12)

    @property
    def gain(self) -> float:
        """Measured against expected size; of the growth, where the motion was looked at twice [-]."""
        if self.first is None:
            return self.size
        measured, expected = self.first
        return math.dist(self.measured, measured) / max(math.dist(self.expected, expected), 1e-12)

    @property
    def angle(self) -> float:
        """Angle between measured and expected motion [rad]."""
        return _angle(self.measured, self.expected)


def agrees(motion: Motion, bounds: Bounds) -> bool:
    """True if a tendon moves the tip as the model says."""
    return bounds.gain_min <= motion.gain <= bounds.gain_max and motion.gain > 0.0 and motion.angle <= bounds.angle


def follows(motion: Motion, bounds: Bounds) -> bool:
    """True if the servo reports about the displacement commanded."""
    part, _ = FOLLOWING
    commanded, reported = motion.commanded, motion.reported
    return reported is None or abs(reported - commanded) <= part * abs(commanded) + bounds.slack


def only_gain(motion: Motion, bounds: Bounds) -> bool:
    """True if nothing but the size of a motion is wrong."""
    return motion.angle <= bounds.angle or motion.size < DEAD


def judge(motions: Sequence[Motion], bounds: Bounds, arms: Sequence[Array] = (), *, finished: bool = True) -> str:
    """Return what is wrong, for people; empty if nothing is.

    Args:
        motions: motions of the tendons, in order. bounds: bounds of what passes.
        arms: arms of all tendons in the cross-section, shape (3,) each: the directions of those not pulled yet.
        finished: all tendons have been pulled; else the last motion is one that was broken off, too large.
    """
    wrong = [index for index, motion in enumerate(motions) if not agrees(motion, bounds)]
    if not wrong:
        return ""
    whole = len(motions) if finished else len(motions) - 1
    expected = [one.expected for one in motions[:whole]] + [tuple(arm.tolist()) for arm in arms[whole:]]
    moves = {index: _moves_as(index, motions, expected, bounds) for index in wrong}
    if not finished and all(moves[index] is None for index in wrong):
        return ""
    lines = [_describe(index, motions, moves[index], bounds) for index in wrong[:NAMED]]
    if len(wrong) > NAMED:
        lines.append(f"and {len(wrong) - NAMED} more tendons")
    return "; ".join([*lines, *_hints(motions, wrong, moves, bounds)])


def _moves_as(
    index: int, motions: Sequence[Motion], expected: Sequence[tuple[float, ...]], bounds: Bounds
) -> int | None:
    """The other tendon as which this one moves the tip, if there is one; `expected` of all tendons."""
    measured = motions[index].measured
    if motions[index].gain < DEAD:
        return None
    angles = [math.inf if other == index else _angle(measured, one) for other, one in enumerate(expected)]
    if not angles:
        return None
    nearest = min(range(len(angles)), key=angles.__getitem__)
    return nearest if angles[nearest] <= min(bounds.angle, motions[index].angle) else None


def _describe(index: int, motions: Sequence[Motion], moves_as: int | None, bounds: Bounds) -> str:
    motion = motions[index]
    if motion.gain < DEAD and not follows(motion, bounds) and motion.reported is not None:
        return (
            f"tendon {index} reports {motion.reported * 1e3:.1f} mm where {motion.commanded * 1e3:.1f} mm are "
            "commanded: does its servo turn?"
        )
    if motion.gain < DEAD:
        return (
            f"tendon {index} does not move the tip ({math.hypot(*motion.measured) * 1e3:.1f} of "
            f"{math.hypot(*motion.expected) * 1e3:.1f} mm): wound the wrong way round, cut, slack, or not connected?"
        )
    if moves_as is not None:
        return f"tendon {index} moves the tip as tendon {moves_as} should"
    degrees = math.degrees(motion.angle)
    if degrees > 20.0:
        return f"tendon {index} moves the tip {degrees:.0f} degrees off its direction"
    return (
        f"tendon {index} moves the tip {motion.gain:.1f} times as far as it should: is its spool's radius, or the "
        "rod's stiffness, right?"
    )


def _hints(motions: Sequence[Motion], wrong: Sequence[int], moves: dict[int, int | None], bounds: Bounds) -> list[str]:
    """Return the single mistakes that would explain it all."""
    hints = []
    taken = {i: moves[i] if motions[i].gain >= DEAD else None for i in wrong}
    pairs = [
        (i, j)
        for i, j in itertools.combinations(wrong, 2)
        if (taken[i] == j and taken[j] in (i, None)) or (taken[j] == i and taken[i] is None)
    ]
    hints += [f"are tendons {i} and {j} swapped?" for i, j in pairs]
    if not pairs and len(wrong) > 1 and all(moves[index] is not None for index in wrong):
        hints.append("are the tendons connected in another order?")
    if all(motion.gain >= DEAD for motion in motions):
        hints += [f"or is the camera's frame {name}?" for name in _frames(motions, bounds)][:1]
    if len(wrong) == len(motions) and all(moves[index] is None for index in wrong):
        gains = [motion.gain for motion in motions]
        if max(gains) < DEAD:
            hints.append("is the power of the servos on, and the arm free?")
    return hints


def _frames(motions: Sequence[Motion], bounds: Bounds) -> list[str]:
    """Mistakes of the camera's frame that explain all motions at once."""
    frames = {
        "mirrored in x": np.diag([-1.0, 1.0, 1.0]),
        "mirrored in y": np.diag([1.0, -1.0, 1.0]),
        "rotated by 180 degrees about z": np.diag([-1.0, -1.0, 1.0]),
        "rotated by 90 degrees about z": np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
        "rotated by -90 degrees about z": np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
        "one with x and y swapped": np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    }
    return [
        name
        for name, matrix in frames.items()
        if all(_angle(one.measured, matrix @ np.array(one.expected)) <= bounds.angle for one in motions)
    ]


def _angle(one: Sequence[float] | Array, other: Sequence[float] | Array) -> float:
    """Return the angle between two vectors [rad]."""
    return math.atan2(float(np.linalg.norm(np.cross(one, other))), float(np.dot(one, other)))
