"""Strain modes of a robot: Legendre polynomials of each component in each section."""

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from tendond.model.strain.discretise.quadrature import NEAR
from tendond.model.strain.robot import Robot

Array = NDArray[np.float64]

BENDING_X, BENDING_Y, TORSION, SHEAR_X, SHEAR_Y, STRETCH = 0, 1, 2, 3, 4, 5
"""Components of the strain (u, v) that have modes."""


class ModeTable:
    """Modes of a robot: component, order and section of each."""

    def __init__(self, robot: Robot) -> None:
        rows: list[tuple[int, int, int]] = []
        self.ranges: list[tuple[int, int]] = []
        for number, section in enumerate(robot.sections):
            first = len(rows)
            counts = (
                (BENDING_X, section.bending_modes), (BENDING_Y, section.bending_modes),
                (TORSION, section.torsion_modes), (SHEAR_X, section.shear_modes), (SHEAR_Y, section.shear_modes),
                (STRETCH, section.stretch_modes),
            )  # fmt: skip
            rows += [(component, order, number) for component, count in counts for order in range(count)]
            self.ranges.append((first, len(rows)))
        table = np.array(rows, dtype=np.int64)
        self.component, self.order = np.ascontiguousarray(table[:, 0]), np.ascontiguousarray(table[:, 1])
        self.count = len(rows)
        self._each = np.eye(int(self.order.max(initial=0)) + 1)  # coefficients of the polynomials, one a column

    def values(self, section: int, part: float) -> Array:
        """Values of all modes at a place in a section, `part` of its length from its base; shape (n,)."""
        found = np.zeros(self.count)
        first, last = self.ranges[section]
        found[first:last] = np.asarray(legendre.legval(2.0 * part - 1.0, self._each))[self.order[first:last]]
        return found


def section_at(robot: Robot, s: float) -> tuple[int, float]:
    """Return the section at an arc length of the backbone, and the arc length from that section's base [m].

    A place between two sections belongs to the one before it.
    """
    begin = 0.0
    for number, section in enumerate(robot.sections):
        if s <= begin + section.length * (1.0 + NEAR) or number == len(robot.sections) - 1:
            return number, min(max(s - begin, 0.0), section.length)
        begin += section.length
    raise AssertionError
