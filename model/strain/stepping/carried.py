"""A base that moves: its poses over a step, and what it carries along.

Points and velocities are those in the world, so that a base that moves is one that puts the rod elsewhere at both ends
of a step: inertia follows, and no fictitious forces are needed. Rates of the strains are what is left of the points'
velocities without what the base carries.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.vectors import Vector, add, cross, rotate, rotate_back, scale, sub
from tendond.model.strain.describe.base import Base
from tendond.model.strain.kinematics import Shape, axis_of, point_of, position_of, rotation_of
from tendond.model.strain.layout import Layout
from tendond.model.strain.se3 import exponential
from tendond.model.strain.stepping.scratch import Scratch

Array = NDArray[np.float64]

MOVING, ROTATION, POSITION, VELOCITY, SPIN, ACCELERATION, SPIN_RATE = 0, 1, 10, 13, 16, 19, 22
"""Where numbers begin in `Scratch.base`: see `Base.row`."""

BEFORE, AFTER, TURN = 0, 6, 12
"""Where numbers begin in `Scratch.carried`: velocity and spin at both ends of a step, and how far the base turns."""


def put_base(layout: Layout, base: Base | None, *shapes: Shape) -> None:
    """Put the base of shapes where it is; none: as the robot has it."""
    for shape in shapes:
        shape.rotation[0] = layout.base if base is None else base.rotation.reshape(-1)
        shape.position[0] = layout.origin if base is None else base.position


@inlined
def _three(values: Any, at: int) -> Vector:
    """Return three numbers of a row."""
    return values[at], values[at + 1], values[at + 2]


@inlined
def _put(shape: Shape, base: Any, time: float) -> None:
    """Put the base of a shape where it is some time after the step's start."""
    turn = add(scale(time, _three(base, SPIN)), scale(0.5 * time * time, _three(base, SPIN_RATE)))
    turned = exponential(turn, (0.0, 0.0, 0.0))[0]
    for c in range(3):  # column by column
        x, y, z = rotate(turned, (base[ROTATION + c], base[ROTATION + 3 + c], base[ROTATION + 6 + c]))
        shape.rotation[0, c], shape.rotation[0, 3 + c], shape.rotation[0, 6 + c] = x, y, z
    for c in range(3):
        moved = base[VELOCITY + c] + 0.5 * time * base[ACCELERATION + c]
        shape.position[0, c] = base[POSITION + c] + time * moved


@lean
def place_base(work: Scratch, begin: float, end: float) -> None:
    """Write poses and motion of the base at both ends of a part of a step, at times after its start [s]."""
    base, carried = work.base, work.carried
    _put(work.before, base, begin)
    _put(work.after, base, end)
    for c in range(6):
        carried[BEFORE + c] = base[VELOCITY + c] + begin * base[ACCELERATION + c]
        carried[AFTER + c] = base[VELOCITY + c] + end * base[ACCELERATION + c]
    for c in range(3):
        carried[TURN + c] = 0.5 * (end - begin) * (carried[BEFORE + 3 + c] + carried[AFTER + 3 + c])


@inlined
def is_moving(work: Scratch) -> bool:
    """Return whether the base moves, or is not where the robot has it."""
    moving: bool = work.base[MOVING] != 0.0
    return moving


@inlined
def carried_velocity(work: Scratch, shape: Shape, at: int, x: Vector) -> Vector:
    """Return the velocity that the base gives a point, at the end `at` of a step."""
    spin = _three(work.carried, at + 3)
    velocity: Vector = add(_three(work.carried, at), cross(spin, sub(x, position_of(shape, 0))))
    return velocity


@inlined
def carried_spin(work: Scratch, shape: Shape, at: int, k: int) -> float:
    """Return the turn that the base gives a node about its own axis: a rate at an end of a step, or all, by `at`."""
    axis, spin = axis_of(shape, k, 2), _three(work.carried, at)
    value: float = axis[0] * spin[0] + axis[1] * spin[1] + axis[2] * spin[2]
    return value


@inlined
def own_move(one: Shape, two: Shape, j: int) -> Vector:
    """Return how far a mass point moves beside the base, world frame: its change in the base's frame, mean of ends."""
    r0, r1 = rotation_of(one, 0), rotation_of(two, 0)
    before = rotate_back(r0, sub(point_of(one.point, j), position_of(one, 0)))
    after = rotate_back(r1, sub(point_of(two.point, j), position_of(two, 0)))
    change = sub(after, before)
    moved: Vector = scale(0.5, add(rotate(r0, change), rotate(r1, change)))
    return moved
