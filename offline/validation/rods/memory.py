"""Curvature that a backbone with dry friction remembers, a vector for each section."""

import math

import numpy as np
from numpy.typing import NDArray

from tendond.model.strain.layout import Layout

Array = NDArray[np.float64]

SETTLED = 3e-3
"""Change of the remembered curvature below which a pose is settled, in parts of the yield curvature."""


class Memory:
    """Remembered curvatures of a rod's sections, which are written into its reference strains.

    Args:
        layout: of a rod without other users: its reference strains are changed.
        share: of the stiffness that yields [-]. limit: yield curvature [1/m].
    """

    def __init__(self, layout: Layout, share: float, limit: float) -> None:
        self._share, self._limit = share, limit
        firsts = np.unique(layout.first)
        at_points = np.argmax(layout.tendon_at != 0.0, axis=1)
        self._held = [[0.0, 0.0] for _ in firsts]
        self._sections = []
        for number, first in enumerate(firsts):
            of_section = (layout.order == 0) & (np.arange(len(layout.order)) >= first)
            modes = [int(np.flatnonzero(of_section & (layout.component == axis))[0]) for axis in (0, 1)]
            rows = []
            for strain, begin in (
                (layout.strain1, layout.first), (layout.strain2, layout.first), (layout.tendon_strain, at_points),
            ):  # fmt: skip
                here = np.flatnonzero(begin == first)
                part = strain[here[0] : here[-1] + 1, :2]  # a view: a section's intervals and points lie together
                rows.append((part, part.copy()))
            self._sections.append((number, modes, rows))

    def yield_to(self, q: Array) -> bool:
        """Let the memory follow the strains q of a rest; return whether another rest must be found.

        q is shifted by the change of the reference, so that the rod keeps its shape.
        """
        moved = False
        for number, (a, b), rows in self._sections:
            x, y = self._held[number]
            dx, dy = q.item(a) - (1.0 - self._share) * x, q.item(b) - (1.0 - self._share) * y
            size = math.hypot(dx, dy)
            if size <= self._limit * (1.0 + SETTLED):
                continue
            part = 1.0 - self._limit / size
            x, y = x + part * dx, y + part * dy
            self._held[number] = [x, y]
            q[a] -= self._share * part * dx
            q[b] -= self._share * part * dy
            for strain, reference in rows:
                strain[:, 0] = reference[:, 0] + self._share * x
                strain[:, 1] = reference[:, 1] + self._share * y
            moved = True
        return moved
