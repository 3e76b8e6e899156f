"""Tilt of the base against gravity: a few degrees are not a fault, but shift the tip. Pure.

The direction of gravity in the base frame is observable, two angles of three: a rotation about gravity does not
change it.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tendond.drivers.mocap.geometry import Alignment, Placement
from tendond.schemas.base import Vector3

TILT_MAX = math.radians(2.0)
"""A base frame that is off by an angle puts the tip of a rod of length L off by L sin(angle): of 0.5 m 17 mm at this
angle, 78 mm at nine degrees."""

TILT_GOOD = 0.75 * TILT_MAX
"""Tilt below which the base counts as level again [rad]."""

SHARE = 0.02
"""Weight of a frame in the mean, to average the noise of single markers."""


class Level:
    """Mean direction of gravity in the base frame.

    Args:
        alignment: alignment of the objects.
        gravity: gravity of the model, in the base frame [m/s^2].

    Attributes:
        tilted: true from a tilt above `TILT_MAX` on, until it is below `TILT_GOOD`.
    """

    def __init__(self, alignment: Alignment, gravity: Vector3) -> None:
        self._alignment = alignment
        self._gravity = gravity
        self._down: NDArray[np.float64] | None = None
        self.tilted = False

    def see(self, base: Placement) -> None:
        """Take a frame's base into the mean."""
        down = self._alignment.down(base)
        mean = down if self._down is None else self._down + SHARE * (down - self._down)
        self._down = mean / np.linalg.norm(mean)
        self.tilted = self.tilt > (TILT_GOOD if self.tilted else TILT_MAX)

    @property
    def tilt(self) -> float:
        """Angle between rod.gravity and the measured direction [rad]; 0 before the first frame."""
        return 0.0 if self._down is None else self._alignment.gravity_angle(self._down)

    def objection(self) -> str:
        """Return a message about a tilted base, with the gravity that fits; empty for a level one."""
        if not self.tilted or self._down is None:
            return ""
        fits = ", ".join(f"{value + 0.0:.2f}" for value in (math.hypot(*self._gravity) * self._down).tolist())
        return (
            f"the base is turned by {math.degrees(self.tilt):.1f} degrees against gravity as rod.gravity has it: level"
            f" it, or fix {self._alignment.key}.base_axes; if it is mounted so, set rod.gravity = [{fits}]"
        )
