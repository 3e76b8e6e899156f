"""Points, frames and tendon paths along the backbone of the general rod, between its nodes."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tendond.model.strain.discretise.modes import BENDING_X, BENDING_Y, ModeTable, section_at
from tendond.model.strain.kinematics import Shape, empty_shape, find_shape
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.state import StrainState

Array = NDArray[np.float64]


class Backbone:
    """The backbone of a robot.

    Args:
        rod: the robot's rod.

    Attributes:
        nodes: arc lengths [m], shape (K + 1,).
    """

    def __init__(self, rod: StrainRod) -> None:
        self._rod = rod
        self.nodes = np.concatenate(([0.0], np.cumsum(rod.layout.step)))
        self._holes = [[tendon.at(float(s)) for s in self.nodes] for tendon in rod.robot.tendons]

    def curve(self, state: StrainState, points: int) -> Array:
        """Return evenly spaced points, for display, world frame [m], shape (points, 3)."""
        return interpolated(self.weights(np.linspace(0.0, self.nodes[-1], points)), self._shape(state))

    def tendon_paths(self, state: StrainState, points: int) -> list[Array]:
        """Return points of each tendon, for display, world frame [m], shapes (k, 3): at most `points` of the nodes."""
        shape = self._shape(state)
        rotations = shape.rotation.reshape(-1, 3, 3)
        paths = []
        for tendon, holes in zip(self._rod.robot.tendons, self._holes, strict=True):
            last = int(np.searchsorted(self.nodes, tendon.end * (1.0 + 1e-9), side="right")) - 1
            kept = np.unique(np.linspace(0, last, min(points, last + 1)).round().astype(np.intp))
            local = np.array([(*holes[k], 0.0) for k in kept])
            paths.append(shape.position[kept] + np.einsum("kij,kj->ki", rotations[kept], local))
        return paths

    def frames(self, state: StrainState, at: Array) -> tuple[Array, Array, Array]:
        """Return positions [m], rotations and spatial twists by the modes, world frame, at arc lengths [m].

        Shapes (p, 3), (p, 3, 3) and (p, 6, n). Between nodes, positions are cubic, rotations turn evenly, and twists
        are in proportion.
        """
        shape, left = self._rod.shape(state), np.clip(np.searchsorted(self.nodes, at) - 1, 0, len(self.nodes) - 2)
        part = (at - self.nodes[left]) / (self.nodes[left + 1] - self.nodes[left])
        rotations = shape.rotation.reshape(-1, 3, 3)
        over = Rotation.from_matrix(np.swapaxes(rotations[left], 1, 2) @ rotations[left + 1]).as_rotvec()
        turned = rotations[left] @ Rotation.from_rotvec(part[:, None] * over).as_matrix()
        one, two = shape.twist[left][:, :, : self._rod.modes], shape.twist[left + 1][:, :, : self._rod.modes]
        twists = one + part[:, None, None] * (two - one)
        return interpolated(self.weights(at), shape), turned, twists

    def bending(self, at: Array) -> tuple[Array, Array]:
        """Return bending strains by the modes at arc lengths [m], shape (2 p, n), and unloaded [1/m], shape (2 p,)."""
        robot, modes = self._rod.robot, ModeTable(self._rod.robot)
        rows, unloaded = [], []
        for s in at:
            number, within = section_at(robot, float(s))
            section = robot.sections[number]
            values = modes.values(number, within / section.length)
            for component in (BENDING_X, BENDING_Y):
                rows.append(np.where(modes.component == component, values, 0.0))
                unloaded.append(float(section.at("curvature", within)[component]))
        return np.array(rows), np.array(unloaded)

    def turned(self, state: StrainState, inner: Array) -> Array:
        """Return moments on the nodes [N m], shape (K + 1, 3), that bend a robot as inner moments of its intervals do.

        Args:
            state: shape of the robot. inner: of each interval, in the frame of its cross-section [N m], shape (K, 3).
        """
        rotations = self._rod.shape(state).rotation.reshape(-1, 3, 3)
        acting = np.einsum("kij,kj->ki", 0.5 * (rotations[:-1] + rotations[1:]), inner)
        moments = np.zeros((len(rotations), 3))
        moments[1:] = acting
        moments[:-1] -= acting
        return moments

    def weights(self, at: Array) -> tuple[Array, Array]:
        """Return weights of the nodes' positions, and of their tangents [m], at arc lengths [m]; shape (p, K + 1)."""
        right = np.clip(np.searchsorted(self.nodes, at), 1, len(self.nodes) - 1)
        left, rows = right - 1, np.arange(len(at))
        step = self.nodes[right] - self.nodes[left]
        t = (at - self.nodes[left]) / step
        places, tangents = np.zeros((2, len(at), len(self.nodes)))
        places[rows, right] = t * t * (3.0 - 2.0 * t)
        places[rows, left] = 1.0 - places[rows, right]
        tangents[rows, left] = step * t * (1.0 - t) ** 2
        tangents[rows, right] = step * t * t * (t - 1.0)
        return places, tangents

    def _shape(self, state: StrainState) -> Shape:
        """Shape in memory of its own: what is for display may run beside a step."""
        shape = empty_shape(self._rod.layout)
        find_shape(self._rod.layout, state.strain, shape)
        return shape


def interpolated(weights: tuple[Array, Array], shape: Shape) -> Array:
    """Return points between the nodes, by a cubic through their positions along their directions [m], shape (p, 3)."""
    return np.asarray(weights[0] @ shape.position + weights[1] @ shape.rotation[:, 2::3])
