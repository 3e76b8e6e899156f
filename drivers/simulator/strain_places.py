"""Cross-sections of the general rod at fixed places: `model.strain.analysis.frames` for a simulator's every step.

The strain at a place is affine in the modes' strains, so its matrix is found once. From the node before a place it is
one step of the kernels' own scheme, as there, with the exponential of SE(3) in closed form.
"""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tendond.drivers.simulator.rotations import right_jacobian
from tendond.model.strain.analysis.frames import strain_at
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.state import StrainState
from tendond.model.strain.twists import COMMUTATOR

Array = NDArray[np.float64]


class StrainPlaces:
    """Places on a general rod.

    Args:
        rod: the rod.
        at: arc lengths [m], shape (places,).

    Raises:
        ParameterError: one does not lie on the backbone.
    """

    def __init__(self, rod: StrainRod, at: Array) -> None:
        self._rod = rod
        nodes = np.concatenate(([0.0], np.cumsum(rod.layout.step)))
        self._node = np.minimum(np.searchsorted(nodes, at, side="right") - 1, len(nodes) - 2)
        start = nodes[self._node]
        self._step = np.maximum(at - start, 0.0)[:, None]
        middle, offset = start + 0.5 * self._step[:, 0], self._step[:, 0] / (2.0 * math.sqrt(3.0))
        self._here, self._first, self._last = (self._affine(s) for s in (at, middle - offset, middle + offset))

    def _affine(self, at: Array) -> tuple[Array, Array]:
        """Return strain without that of the modes, shape (places, 6), and its matrix by them, shape (places, 6, n)."""
        rest = self._rod.rest()
        free = strain_at(self._rod, rest, at)
        modes = [strain_at(self._rod, StrainState(unit, rest.rate), at) - free for unit in np.eye(self._rod.modes)]
        return free, np.stack(modes, axis=2)

    def find(self, state: StrainState) -> tuple[Array, Array, Array]:
        """Return positions, orientations and strains of a state of the rod.

        Returns:
            Positions [m], shape (places, 3); orientations, body to base, shape (places, 3, 3); strains, u [1/m] and
            v [-], shape (places, 6).
        """
        q, shape = state.strain, self._rod.shape(state)
        here, first, last = (free + matrix @ q for free, matrix in (self._here, self._first, self._last))
        (u1, v1), (u2, v2) = (first[:, :3], first[:, 3:]), (last[:, :3], last[:, 3:])
        bracket = np.hstack((np.cross(u1, u2), np.cross(u1, v2) - np.cross(u2, v1)))
        magnus = 0.5 * self._step * (first + last) + COMMUTATOR * self._step**2 * bracket
        turn, way = magnus[:, :3], magnus[:, 3:]
        before = shape.rotation[self._node].reshape(-1, 3, 3)
        moved = np.einsum("kji,kj->ki", right_jacobian(turn), way)
        position = shape.position[self._node] + np.einsum("kij,kj->ki", before, moved)
        return position, before @ Rotation.from_rotvec(turn).as_matrix(), here
