"""The rests that a right rig may have, and how far a measured one is from the nearest of them.

A right rig differs from the configuration by a weight that hangs on its tip, by its stiffness, by a base that is a
little turned or displaced, and by markers that sit a little askew on the tip. Weight and stiffness are a grid of
equilibria, computed once. The other three are small, and their likeliest values follow from the six measured numbers
in closed form: with the base turned by q and displaced by o, a rest (p, R) is seen at
(p + q x p + o, exp(a) exp(q) R). The misfit

    J = min over q of  |q|^2 / tilt^2 + |a|^2 / orientation^2 + |o|^2 / (offset L)^2

is a sum of squares in units of the tolerances: a right rig with its base turned and displaced by as much has J = 2.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ConvergenceError
from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.rod import Rod
from tendond.schemas.config.rig import RigConfig

Array = NDArray[np.float64]

MISFIT_MAX = 2.0
"""Misfit up to which a rest is right: base turned and displaced by its tolerance, both at once."""

FREE = 1e6
"""Factor by which a tolerance is widened that is not asked about."""

WEIGHTS, STIFFNESSES = 16, 4
"""Equilibria over the range of each; linear between them."""

WEIGHT_STEPS, STIFFNESS_STEPS = 6, 3
"""Parts of an interval between two of them: the grid's rests are then within 0.3 % of the paper's rod of each other."""

OWN_WEIGHTS = 1.2
"""Default of the largest weight, of the rod's mass and EI/(L^2 g) together: 105 g for the paper's robot."""


@dataclass(frozen=True)
class Tolerances:
    """Tolerances: `tilt` and `offset` of the base [rad, m], `orientation` of the markers on the tip [rad]."""

    tilt: float
    offset: float
    orientation: float


@dataclass(frozen=True)
class Fit:
    """The nearest rest of a right rig.

    Attributes:
        misfit: J.
        weight: mass on the tip [kg]. stiffness: ratio to the configuration's [-].
        position: position of that rest's tip [m], shape (3,).
        tilt: q, of the base [rad], shape (3,).
        offset: o, of the base [m], shape (3,).
    """

    misfit: float
    weight: float
    stiffness: float
    position: Array
    tilt: Array
    offset: Array

    @property
    def is_tolerated(self) -> bool:
        """True if a right rig may rest so."""
        return self.misfit <= MISFIT_MAX


@dataclass(frozen=True)
class RestFamily:
    """Rests under every weight and stiffness of a grid.

    Attributes:
        length: length of the rod [m].
        tolerances: bounds of what is not on the grid.
        weights: [kg], stiffnesses: [-], shapes (m,).
        positions: [m], shape (m, 3). rotations: shape (m, 3, 3).
    """

    length: float
    tolerances: Tolerances
    weights: Array
    stiffnesses: Array
    positions: Array
    rotations: Array

    def may_fit(self, position: Array) -> bool:
        """True if a tip there [m], shape (3,), can be one of a right rig: `fit` in a fraction of its time, too kind."""
        tolerances = MISFIT_MAX**0.5 * (self.tolerances.tilt * self.length + self.tolerances.offset)
        apart = self.positions - position
        return bool(np.min(np.einsum("mi,mi->m", apart, apart)) <= (2.0 * tolerances) ** 2)

    def fit(self, position: Array, rotation: Array, tolerances: Tolerances | None = None) -> Fit:
        """Fit the family to a measured rest.

        Args:
            position: position of the tip [m], shape (3,). rotation: rotation of it, shape (3, 3).
            tolerances: in place of the family's own.
        """
        tolerances = tolerances or self.tolerances
        p = self.positions
        turn = rotation_vectors(rotation @ self.rotations.transpose(0, 2, 1))
        apart = position - p
        stiff_t, stiff_o, stiff_p = tolerances.tilt**-2, tolerances.orientation**-2, tolerances.offset**-2
        square = np.einsum("mi,mi->m", p, p)
        matrix = stiff_p * (square[:, None, None] * np.eye(3) - np.einsum("mi,mj->mij", p, p))
        matrix += (stiff_t + stiff_o) * np.eye(3)
        q = np.linalg.solve(matrix, (stiff_o * turn + stiff_p * np.cross(p, apart))[..., None])[..., 0]
        rest, left = apart - np.cross(q, p), turn - q
        misfit = stiff_t * np.sum(q * q, 1) + stiff_o * np.sum(left * left, 1) + stiff_p * np.sum(rest * rest, 1)
        best = int(np.argmin(misfit))
        return Fit(
            float(misfit[best]), float(self.weights[best]), float(self.stiffnesses[best]), p[best], q[best], rest[best]
        )


def rotation_vectors(rotations: Array) -> Array:
    """Axis times angle [rad] of rotation matrices, shape (..., 3, 3) to (..., 3)."""
    r = rotations
    axial = 0.5 * np.stack(
        [r[..., 2, 1] - r[..., 1, 2], r[..., 0, 2] - r[..., 2, 0], r[..., 1, 0] - r[..., 0, 1]], axis=-1
    )
    sine = np.linalg.norm(axial, axis=-1)
    angle = np.arctan2(sine, 0.5 * (np.trace(r, axis1=-2, axis2=-1) - 1.0))
    # Half a turn has no sine, and its axis is the column of R + 1 that is longest.
    whole = r + np.eye(3)
    longest = np.argmax(np.linalg.norm(whole, axis=-2), axis=-1)
    column = np.take_along_axis(whole, longest[..., None, None], axis=-1)[..., 0]
    half = column / np.maximum(np.linalg.norm(column, axis=-1, keepdims=True), 1e-12)
    axis = np.where(sine[..., None] > 1e-6, axial / np.maximum(sine, 1e-12)[..., None], half)
    return np.where((angle < 1e-6)[..., None], axial, axis * angle[..., None])


def turn_by(vector: Array) -> Array:
    """Rotation matrix of axis times angle [rad], shape (3,) to (3, 3)."""
    angle = float(np.linalg.norm(vector))
    x, y, z = np.sin(0.5 * angle) / max(angle, 1e-12) * vector
    return rotation_matrix((float(np.cos(0.5 * angle)), x, y, z))


def rotation_matrix(quaternion: tuple[float, ...] | Array) -> Array:
    """Rotation matrix of a quaternion w, x, y, z of about unit size, shape (3, 3)."""
    w, x, y, z = np.asarray(quaternion) / np.linalg.norm(quaternion)
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def largest_weight(parameters: RodParameters) -> float:
    """The weight [kg] up to which a tip may be loaded, by the robot: its own mass and EI/(L^2 g)."""
    gravity = float(np.linalg.norm(parameters.gravity))
    stiff = parameters.bending_stiffness / (parameters.length**2 * gravity) if gravity else 0.0
    return OWN_WEIGHTS * (parameters.mass_per_length * parameters.length + stiff)


def configured_rests(config: RigConfig, parameters: RodParameters) -> RestFamily | None:
    """The family that a configuration describes; none where it asks for no comparison.

    Raises:
        ConvergenceError: the rod has no rest.
    """
    section = config.commissioning
    if not section.rest:
        return None
    tolerances = Tolerances(section.tilt, section.offset * parameters.length, section.orientation)
    weight = largest_weight(parameters) if section.weight_max is None else section.weight_max
    return rest_family(parameters, config.rod.space, config.rod.nodes, section.stiffness, weight, tolerances)


@lru_cache(maxsize=64)
def rest_family(
    parameters: RodParameters,
    space: str,
    nodes: int | None,
    stiffness: float,
    weight_max: float,
    tolerances: Tolerances,
) -> RestFamily:
    """Compute the family of a rod.

    Args:
        parameters: parameters of the model. space, nodes: of its discretisation.
        stiffness: by which Young's modulus may differ [-].
        weight_max: the largest weight on the tip [kg].
        tolerances: tolerances of the rest.

    Raises:
        ConvergenceError: the rod has no rest without a weight.
    """
    gravity = np.array(parameters.gravity)
    loaded = bool(gravity.any())
    factors = np.linspace(1.0 / (1.0 + stiffness), 1.0 / (1.0 - min(stiffness, 0.75)), STIFFNESSES + 1)
    compliances = factors if loaded else np.ones(1)
    weights = np.linspace(0.0, weight_max, WEIGHTS + 1) if loaded else np.zeros(1)
    rows: list[tuple[Array, Array]] = []
    for compliance in compliances:
        rod = Rod(replace(parameters, youngs_modulus=parameters.youngs_modulus / float(compliance)), space, nodes)
        rows.append(_hung(rod, weights, gravity))
    reached = min(len(positions) for positions, _ in rows)  # a rod buckles beyond
    positions = np.stack([one[:reached] for one, _ in rows])
    rotations = np.stack([one[:reached] for _, one in rows])
    for axis, steps, count in ((0, STIFFNESS_STEPS, len(compliances)), (1, WEIGHT_STEPS, reached)):
        if count > 1:
            positions, rotations = _between(positions, steps, axis), _between(rotations, steps, axis)
    compliances = np.interp(np.linspace(0, 1, positions.shape[0]), np.linspace(0, 1, len(compliances)), compliances)
    grid_c, grid_w = np.meshgrid(compliances, np.linspace(0.0, weights[reached - 1], positions.shape[1]), indexing="ij")
    return RestFamily(
        parameters.length, tolerances, grid_w.ravel(), 1.0 / grid_c.ravel(), positions.reshape(-1, 3),
        _orthonormal(rotations.reshape(-1, 3, 3)),
    )  # fmt: skip


def _hung(rod: Rod, weights: Array, gravity: Array) -> tuple[Array, Array]:
    """Tips and rotations of one rod under rising weights, up to buckling."""
    slack = np.zeros(rod.parameters.tendon_count)
    state, tips = None, []
    for weight in weights:
        try:
            state = rod.solve_static(slack, tip_force=weight * gravity, start=state)
        except ConvergenceError:
            if state is None:
                raise
            break
        tips.append(rod.tip(state))
    return np.stack([tip.position for tip in tips]), np.stack([tip.rotation for tip in tips])


def _between(values: Array, steps: int, axis: int) -> Array:
    """`values` with linear ones between each two along an axis."""
    moved = np.moveaxis(values, axis, 0)
    at = np.linspace(0.0, len(moved) - 1.0, steps * (len(moved) - 1) + 1)
    low = np.minimum(at.astype(int), len(moved) - 2)
    part = (at - low).reshape(-1, *[1] * (moved.ndim - 1))
    return np.moveaxis((1.0 - part) * moved[low] + part * moved[low + 1], 0, axis)


def _orthonormal(rotations: Array) -> Array:
    """The nearest rotations to means of neighbouring ones."""
    u, _, v = np.linalg.svd(rotations)
    return np.asarray(u @ v)
