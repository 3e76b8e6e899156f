"""Cross-sections of a simulated rod at any arc length, and the motion of its tip: what its sensors measure.

The shooting rod knows its nodes alone. Between two of them the rotation vector from the first one, and the position,
are cubics with the nodes' values and slopes; the curvature is the derivative of that rotation. The general rod knows
its strain everywhere.
"""

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tendond.drivers.simulator.rods import GeneralPlantRod, PlantRod
from tendond.drivers.simulator.rotations import right_jacobian
from tendond.model.rod.rod import Rod
from tendond.model.rod.state import RodState

Array = NDArray[np.float64]


@runtime_checkable
class KnowsCrossSections(Protocol):
    """A plant's rod that knows its cross-sections anywhere."""

    def cross_sections(self, state: Any, at: Array) -> tuple[Array, Array, Array]:
        """Return positions, orientations and strains; see `StrainPlaces.find`."""


@runtime_checkable
class KnowsTipMotion(Protocol):
    """A plant's rod that knows its tip's rate and acceleration itself."""

    def tip_motion(self, state: Any) -> tuple[Array, Array]:
        """Return angular rate, body frame [rad/s], and acceleration, base's frame [m/s^2], shape (3,) each."""


BODY_RATE = slice(9, 12)
"""Angular rate w among the levels of a node, `model.rod.state.RodState`."""


@dataclass(frozen=True)
class CrossSections:
    """Cross-sections at some arc lengths, base's frame.

    Attributes:
        position: [m], shape (places, 3). rotation: body to base, shape (places, 3, 3).
        curvature: u_x, u_y about the own axes, with that of the unloaded rod [1/m], shape (places, 2).
    """

    position: Array
    rotation: Array
    curvature: Array


def cross_sections(rod: PlantRod, state: Any, at: Array) -> CrossSections:
    """Return the cross-sections of a state of the rod at arc lengths [m], shape (places,)."""
    if isinstance(rod, Rod):
        return _between_nodes(rod, state, at)
    assert isinstance(rod, KnowsCrossSections)
    position, rotation, strain = rod.cross_sections(state, at)
    return CrossSections(position, rotation, strain[:, :2])


def tip_motion(rod: PlantRod, before: Any, state: Any) -> tuple[Array, Array]:
    """Return angular rate of the tip, body frame [rad/s], and acceleration, base's frame [m/s^2], shape (3,) each.

    Rates of the general rod alternate from step to step about their means (`model.rods.general`), so they are those
    over its last step, that from `before`, and the acceleration is from the mean of the step before that one to it:
    half a step and a whole step old.
    """
    if isinstance(rod, GeneralPlantRod):
        turn = Rotation.from_matrix(rod.tip(before).rotation.T @ rod.tip(state).rotation)
        return turn.as_rotvec() / rod.time_step, (state.velocity - before.velocity) / rod.time_step
    if isinstance(rod, KnowsTipMotion):
        return rod.tip_motion(state)
    assert isinstance(rod, Rod)
    return state.levels[state.count % 3, -1, BODY_RATE].copy(), rod.tip(state).acceleration


class _Nodes:
    """Some nodes of a shooting rod: position, orientation, tangent and curvature.

    Args:
        state: of the rod. levels: of all nodes, shape (nodes, 18). index: of these nodes.
    """

    def __init__(self, state: RodState, levels: Array, index: NDArray[np.intp]) -> None:
        geometry, strain = state.geometries[state.count % 2][index], levels[index]
        self.place, self.turn = geometry[:, :3], Rotation.from_matrix(geometry[:, 3:].reshape(-1, 3, 3))
        self.tangent = self.turn.apply(strain[:, :3] + np.array((0.0, 0.0, 1.0)))
        self.curvature = strain[:, 3:6]


def _between_nodes(rod: Rod, state: RodState, at: Array) -> CrossSections:
    """Return the cross-sections of a shooting rod; see the module."""
    nodes = np.linspace(0.0, rod.parameters.length, rod.nodes)
    levels = state.levels[state.count % 3, :: len(rod.scheme.weights)]
    first = np.clip(np.searchsorted(nodes, at, side="right") - 1, 0, len(nodes) - 2)
    near, far = (_Nodes(state, levels, node) for node in (first, first + 1))
    t, step = ((at - nodes[first]) / nodes[1])[:, None], nodes[1]
    turn_far = (near.turn.inv() * far.turn).as_rotvec()
    slope_far = np.linalg.solve(right_jacobian(turn_far), far.curvature[:, :, None])[:, :, 0]
    turn, rate = _cubic(t, np.zeros_like(turn_far), turn_far, step * near.curvature, step * slope_far)
    curvature = np.einsum("kij,kj->ki", right_jacobian(turn), rate / step)
    position, _ = _cubic(t, near.place, far.place, step * near.tangent, step * far.tangent)
    return CrossSections(position, (near.turn * Rotation.from_rotvec(turn)).as_matrix(), curvature[:, :2])


def _cubic(t: Array, start: Array, end: Array, slope: Array, end_slope: Array) -> tuple[Array, Array]:
    """Return the Hermite cubic on [0, 1] and its derivative at t, shape (places, 1): values of shape (places, 3)."""
    change = end - start
    value = start + t * (slope + t * (3.0 * change - 2.0 * slope - end_slope + t * (slope + end_slope - 2.0 * change)))
    rate = slope + t * (2.0 * (3.0 * change - 2.0 * slope - end_slope) + 3.0 * t * (slope + end_slope - 2.0 * change))
    return value, rate
