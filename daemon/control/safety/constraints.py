"""All constraints of a motion, as values that must stay above zero, and their derivatives by the command."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.safety.geometry import Surfaces
from tendond.model.body.clearance import Kept, find_clearance
from tendond.model.numerics.compile import Bound
from tendond.schemas.config.safety.section import SafetySection

Array = NDArray[np.float64]

STRAIN = "strain"
"""Name of the constraint on the strain in messages."""


Moved = tuple[Array, Array]
"""Changes of points and bends at the samples of a motion."""

ALONE = np.ones(1)
"""Weight of a motion that consists of one."""


class Values(NamedTuple):
    """Constraints at each sample, above zero where they are kept.

    Attributes:
        clear: of surfaces [m], then of strain [-], less margins, shape (k, r). slopes: of the surfaces' by the moves of
            their points, shape (k, s, 3); of the strains' by the bends, shape (k, b, 2).
        reach: longest move of each surface's point [m], largest change of each bend [-], shape (r,).
    """

    clear: Array
    slopes: Array
    bend_slopes: Array
    reach: Array


class Constraints:
    """The constraints of a configuration.

    Args:
        section: [safety]. surfaces: its obstacles and region. strain_max: [-]; none: unlimited. bends: their number, b.
        spacing: time between samples [s].

    Attributes:
        names: of each row, shape (r,), for messages. surfaces: as given. bends: number of bends in use.
        margin: kept from each surface [m].
    """

    def __init__(
        self, section: SafetySection, surfaces: Surfaces, strain_max: float | None, bends: int, spacing: float
    ) -> None:
        self.surfaces = surfaces
        self.margin = section.margin + section.position_error
        self.bends = 0 if strain_max is None else bends
        limit = np.inf if strain_max is None else strain_max
        self._kept = Kept(self.margin, section.stiffness_error, section.delay_error / spacing, limit)
        self._find = Bound(find_clearance)
        self.names = [surfaces.names[index] for index in surfaces.surface] + [STRAIN] * self.bends

    def values(self, points: Array, bends: Array, moved: Moved, weights: Array = ALONE) -> Values:
        """Return the constraints along a motion.

        Args:
            points: now [m], shape (p, 3). bends: now [-], shape (b, 2).
            moved: changes of them, shapes (k, p, 3, c) and (k, b, 2, c). weights: of these c, shape (c,).
        """
        moves, turns = moved
        k, rows = len(moves), self.surfaces.count
        found = Values(
            np.empty((k, rows + self.bends)), np.empty((k, rows, 3)), np.empty((k, self.bends, 2)),
            np.empty(rows + self.bends),
        )  # fmt: skip
        self._find.call(self.surfaces.rows, self._kept, points, bends[: self.bends], moves, turns, weights, *found)
        return found

    def slopes(self, values: Values, moves: Array, turns: Array) -> Array:
        """Return derivatives of all constraints by the command, sample by sample, shape (k r, m)."""
        by_surface = np.einsum("kri,krim->krm", values.slopes, moves[:, self.surfaces.point, :, 1:])
        by_strain = np.einsum("kbi,kbim->kbm", values.bend_slopes, turns[..., 1:])
        return np.concatenate((by_surface, by_strain), axis=1).reshape(-1, moves.shape[-1] - 1)
