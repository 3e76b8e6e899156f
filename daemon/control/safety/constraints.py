"""All constraints of a motion, as values that must stay above zero, and their derivatives by the command."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.safety.body import Shape
from tendond.daemon.control.safety.geometry import Surfaces
from tendond.daemon.control.safety.horizon import Motion
from tendond.schemas.config.safety.section import SafetySection

Array = NDArray[np.float64]

STRAIN = "strain"
"""Name of the constraint on the strain in messages."""

NORM_MIN = 1e-12
"""Move [m] or bend [-] below which it has no direction."""


class Values(NamedTuple):
    """Constraints at each sample, above zero where they are kept.

    Attributes:
        clear: of surfaces [m], then of strain [-], less margins, shape (k, r). slopes: of the surfaces' by the moves of
            their points, shape (k, s, 3); of the strains' by the bends, shape (k, b, 2).
    """

    clear: Array
    slopes: Array
    bend_slopes: Array


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
        self._section, self._strain_max, self._spacing = section, strain_max, spacing
        self.bends = 0 if strain_max is None else bends
        self.names = [surfaces.names[index] for index in surfaces.surface] + [STRAIN] * self.bends

    def project(self, shape: Shape, bend_rows: Array, motion: Motion) -> tuple[Array, Array]:
        """Return moves of the points [m], (k, p, 3, 1 + m), and changes of the bends [-], (k, b, 2, 1 + m)."""
        both = np.concatenate((motion.free[:, :, None], motion.by_command), axis=2)
        k, n, columns = both.shape
        flat = np.ascontiguousarray(both.transpose(1, 0, 2)).reshape(n, -1)
        moves = (shape.jacobians.reshape(-1, n) @ flat).reshape(-1, 3, k, columns).transpose(2, 0, 1, 3)
        bends = (bend_rows[: self.bends].reshape(-1, n) @ flat).reshape(-1, 2, k, columns).transpose(2, 0, 1, 3)
        return moves, bends

    def values(self, points: Array, bends: Array, moves: Array, turns: Array) -> Values:
        """Return the constraints of points [m], (p, 3), and bends [-], (b, 2), moved by (k, p, 3) and (k, b, 2)."""
        section, at = self._section, self.surfaces.point
        measured = self.surfaces.measure(points + moves)
        relative, far = section.stiffness_error, moves[:, at]
        way = np.sqrt(np.einsum("kri,kri->kr", far, far))
        kept = self.margin + relative * way
        if section.delay_error > 0.0:
            close = moves  # the later samples are further apart
            parts = np.diff(close, axis=0, prepend=0.0)
            fastest = np.sqrt(np.einsum("kpi,kpi->kp", parts, parts)).max(axis=0) / self._spacing
            kept = kept + section.delay_error * fastest[at]
        clear = measured.values - kept
        slopes = measured.normals - (relative / np.maximum(way, NORM_MIN))[..., None] * far
        bent = bends[: self.bends] + turns
        if self._strain_max is None:
            return Values(clear, slopes, turns)
        size, change = np.sqrt(np.einsum("kbi,kbi->kb", bent, bent)), np.sqrt(np.einsum("kbi,kbi->kb", turns, turns))
        clear = np.concatenate((clear, self._strain_max - (1.0 + relative) * size - relative * change), axis=1)
        turning = -(1.0 + relative) * bent / np.maximum(size, NORM_MIN)[..., None]
        return Values(clear, slopes, turning - (relative / np.maximum(change, NORM_MIN))[..., None] * turns)

    def slopes(self, values: Values, moves: Array, turns: Array) -> Array:
        """Return derivatives of all constraints by the command, sample by sample, shape (k r, m)."""
        by_surface = np.einsum("kri,krim->krm", values.slopes, moves[:, self.surfaces.point, :, 1:])
        by_strain = np.einsum("kbi,kbim->kbm", values.bend_slopes, turns[..., 1:])
        return np.concatenate((by_surface, by_strain), axis=1).reshape(-1, moves.shape[-1] - 1)
