"""Where the tip should be, as a function of the time since tracking began."""

import math

from tendond.schemas.config import ReferenceSection
from tendond.schemas.record import ReferencePoint

PLANES = {"xz": (0, 2), "yz": (1, 2)}
"""World axes of a bending plane: across the straight rod, and along it."""


def reference_at(section: ReferenceSection, plane: str, time: float) -> ReferencePoint:
    """The reference's point.

    `exponential` is the paper's: the component across the rod goes as X (1 - exp(-rate t)) from zero, the one along
    it is at its target at once (the paper asks for z = 0, which no shape with x = 340 mm has).

    Args:
        section: of the configuration.
        plane: name in `PLANES`.
        time: since tracking began [s].
    """
    target = section.target
    if section.kind == "step":
        return ReferencePoint(position=target, velocity=(0.0, 0.0, 0.0), acceleration=(0.0, 0.0, 0.0))
    across = PLANES[plane][0]
    rest = math.exp(-section.rate * time)
    position, velocity, acceleration = list(target), [0.0] * 3, [0.0] * 3
    position[across] = target[across] * (1.0 - rest)
    velocity[across] = target[across] * section.rate * rest
    acceleration[across] = -target[across] * section.rate**2 * rest
    return ReferencePoint(
        position=(position[0], position[1], position[2]),
        velocity=(velocity[0], velocity[1], velocity[2]),
        acceleration=(acceleration[0], acceleration[1], acceleration[2]),
    )
