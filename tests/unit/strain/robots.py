"""Robots that several tests of the strain rod use."""

import math
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
