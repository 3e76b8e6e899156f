"""Robots that several tests of the strain rod use."""

import math
from dataclasses import replace
from typing import Any

from tendond.model.strain import Body, Robot, Section, Tendon

FOUR = tuple((0.02 * math.cos(a), 0.02 * math.sin(a)) for a in (0.0, math.pi / 2, math.pi, 3 * math.pi / 2))


def paper(
    damping: float = 0.008,
    drag: float = 0.1,
    gravity: tuple[float, float, float] = (-9.81, 0.0, 0.0),
    bodies: tuple[Body, ...] = (),
    **more: Any,
) -> Robot:
    """The robot of Danesh & Janabi-Sharifi (table 1), tendons parallel to the backbone."""
    section = Section.round(
        0.5, 1e-3, 190e9, 17189.0, bending_damping=(damping,) * 3, drag=(drag,) * 3, **more
    )  # fmt: skip
    return Robot((section,), tuple(Tendon(0.5, route, 2e4) for route in FOUR), bodies, gravity)


def nitinol(damping: float = 0.00536, radius: float = 0.25e-3) -> Robot:
    """A wire of 0.3 m with tendons at 2 mm; `damping` [s] of its bending stiffness: 4 % of the first mode."""
    plain = Section.round(0.3, radius, 60e9, 6450.0)
    section = replace(plain, bending_damping=(damping * plain.bending_stiffness[0],) * 3)
    return Robot((section,), tuple(Tendon(0.3, (0.1 * x, 0.1 * y)) for x, y in FOUR), (), (-9.81, 0.0, 0.0))


def with_modes(robot: Robot, bending: int) -> Robot:
    """The robot with so many bending modes a section."""
    return replace(robot, sections=tuple(replace(one, bending_modes=bending) for one in robot.sections))


def rubbing(robot: Robot, friction: float) -> Robot:
    """The robot with tendons that rub."""
    return replace(robot, tendons=tuple(replace(one, friction=friction) for one in robot.tendons))
