"""State of the general rod at one instant."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.strain.describe.base import Base

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StrainState:
    """State of the robot at one instant.

    Attributes:
        strain: of the modes [1/m, or - for stretch], shape (n,). rate: of it [1/s], shape (n,).
        iterations: Newton's, of the solution that led here. steps: that the last step was split into.
        damped: how many of these were implicit Euler's, where no other solution was found: they take energy away.
        earlier: rates one and two steps before, for a first guess of the next step, and the estimate of its error.
        base: pose and motion of the base; none: at rest, as the robot has it.
        pulls: tensions along the F tendons with friction, in their order: at the servo's end, then at the robot's Q
            tendon points [N], shape (F, 1 + Q); see `friction.tensions`. None: of slack tendons, or without friction.
        friction_work: of the last step or rest, which friction took away [J]; of a split step its last part only.
    """

    strain: Array
    rate: Array
    iterations: int = 0
    steps: int = 0
    damped: int = 0
    earlier: tuple[Array, Array] | None = None
    base: Base | None = None
    pulls: Array | None = None
    friction_work: float = 0.0


def trend_of(earlier: tuple[Array, Array] | None) -> Array | float:
    """Return by how much the mean rates of the coming step differ from those before it, by two earlier ones [1/s].

    With means of neighbouring rates, (w0 + w-1)/2 and (w-1 + w-2)/2, which do not alternate from step to step as the
    rates of fast modes do, the next mean is w0 + (w-1 - w-2)/2.

    Args:
        earlier: rates one and two steps before, each of shape (n,); none: nothing is known of them.
    """
    return 0.0 if earlier is None else 0.5 * (earlier[0] - earlier[1])
