"""Goal of a law that moves the tip in space: a place, and how the tendons move the resting tip there."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Goal:
    """Target of a law that moves the tip in space.

    Attributes:
        place: position [m] or direction [-] of the tip, shape (3,).
        jacobian: derivative of `place` by the tendons' bending moment in the resting rod, shape (3, 2); none where it
            is not known.
    """

    place: Array
    jacobian: Array | None
