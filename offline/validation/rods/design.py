"""What is known of a measured robot before it is fitted: sections, tendons, sizes. The rest has priors."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Design:
    """A robot as its description gives it; only ratios of forces can be told from displacements and tips.

    Attributes:
        lengths: of the sections [m], shape (S,).
        ends: section at whose end each tendon is fixed, 0 to S - 1, shape (m,).
        angles: of the tendons about the backbone [rad], shape (m,). radius: of all of them [m].
        up: orientation of the base in the camera's frame where the robot is straight, shape (3, 3): its z axis is the
            backbone.
        origin: position of the base, camera's frame [m], shape (3,).
        spread: relative sigmas of length and radius, as they were given.
        tendon_stiffness: k r^2 L / EI [-]. axial_stiffness: EA r^2 / EI [-].
        marker: from the tip to the marker along the backbone [m].
        start: values that a fit starts from, by parameter, where they are not the priors' centres.
    """

    lengths: tuple[float, ...]
    ends: tuple[int, ...]
    angles: tuple[float, ...]
    radius: float
    up: Array
    origin: tuple[float, float, float]
    spread: tuple[float, float] = (0.2, 0.3)
    tendon_stiffness: float = 20.0
    axial_stiffness: float = 300.0
    marker: float = 0.0
    start: dict[str, float] = field(default_factory=dict)

    @property
    def length(self) -> float:
        """Length of the backbone [m]."""
        return sum(self.lengths)
