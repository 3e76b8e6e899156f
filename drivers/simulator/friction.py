"""Friction of the tendons on the disks: the capstan equation, lumped at the middle of a tendon's path.

Where a tendon's path bends by the angle phi, a pull T before it is T e^(-mu phi) behind it while the tendon slides
forward, T e^(mu phi) while it slides back, and anything between while it sticks (Euler 1769, Eytelwein 1808; along a
tendon-driven robot: Kato et al., "Tendon-driven continuum robot for endoscopic surgery: preclinical development and
validation of a tension propagation model", IEEE/ASME Trans. Mechatronics 20, 2015). This is for the
shooting rod, which has one tension for each tendon: it is given that of the path's middle, behind half of the bend, and
the tendon stretches half before and half behind it. The general rod has friction along the whole path
(`model.strain.friction`).
"""

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def grip(coefficient: float, bend: float) -> float:
    """Return the ratio of the tensions before and behind the middle of the path of a sliding tendon: e^(mu phi/2).

    Args:
        coefficient: coefficient of friction, mu [-].
        bend: bend of the whole path, phi [rad].
    """
    return math.exp(0.5 * coefficient * abs(bend))


def between(behind: Array, before: Array, ratio: float) -> Array:
    """Return the tension behind the middle [N], shape (n,), for a new one before it [N]; it sticks within the ratio."""
    return np.clip(behind, before / ratio, ratio * before)


class TendonMiddles:
    """Positions of the middles of elastic tendons under friction.

    Args:
        stiffness: stiffness of a whole tendon [N/m], or of each, shape (n,).
        ends: displacement of the servos' ends [m], shape (n,).
        shortening: length by which the rod has shortened each path [m], shape (n,); without friction until now.
    """

    def __init__(self, stiffness: float | Array, ends: Array, shortening: Array) -> None:
        self._half = 2.0 * stiffness
        self._place = 0.5 * (ends + shortening)

    def _slid(self, ends: Array, shortening: Array, ratio: float) -> Array:
        """Return the new positions [m], shape (n,): they stay, or slide until friction holds them."""
        taut = ends > shortening
        forward = np.where(taut, (ends + ratio * shortening) / (1.0 + ratio), ends)
        back = np.where(taut, (ratio * ends + shortening) / (1.0 + ratio), shortening)
        return np.clip(self._place, forward, back)

    def given(self, ends: Array, shortening: Array, ratio: float) -> Array:
        """Return ends of tendons without friction that pull the rod equally [m], shape (n,).

        Behind its middle m a tendon pulls with 2k (m - d), d the shortening: as k (D - d) with D = 2m - d does.
        """
        return np.where(ends > shortening, 2.0 * self._slid(ends, shortening, ratio) - shortening, ends)

    def slide(self, ends: Array, shortening: Array, ratio: float) -> None:
        """Accept new ends [m] and shortening [m], each of shape (n,)."""
        self._place = self._slid(ends, shortening, ratio)

    def tension(self, ends: Array) -> Array:
        """Return the tension before the middle, the servos' load [N], shape (n,)."""
        return np.maximum(0.0, self._half * (ends - self._place))
