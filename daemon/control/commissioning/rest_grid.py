"""The grid of equilibria under every weight and stiffness that a right rig may have, computed once for each rod."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.commissioning.rests import RestFamily, Tolerances
from tendond.model.errors import ConvergenceError
from tendond.model.rod.parameters import RodParameters
from tendond.model.rods.interface import ModelRod
from tendond.model.rods.selection import RodSource, source_of
from tendond.schemas.config.rig import RigConfig

Array = NDArray[np.float64]

WEIGHTS, STIFFNESSES = 16, 4
"""Equilibria over the range of each; linear between them."""

WEIGHT_STEPS, STIFFNESS_STEPS = 6, 3
"""Parts of an interval between two of them: the grid's rests are then within 0.3 % of the paper's rod of each other."""

OWN_WEIGHTS = 1.2
"""Default of the largest weight, of the rod's mass and EI/(L^2 g) together: 105 g for the paper's robot."""


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
    return rest_family(source_of(config), section.stiffness, weight, tolerances)


@lru_cache(maxsize=64)
def rest_family(
    source: RodSource,
    stiffness: float,
    weight_max: float,
    tolerances: Tolerances,
) -> RestFamily:
    """Compute the family of a rod.

    Args:
        source: what the model is made from.
        stiffness: by which Young's modulus may differ [-].
        weight_max: the largest weight on the tip [kg].
        tolerances: tolerances of the rest.

    Raises:
        ConvergenceError: the rod has no rest without a weight.
    """
    parameters = source.rod().parameters
    gravity = np.array(parameters.gravity)
    loaded = bool(gravity.any())
    factors = np.linspace(1.0 / (1.0 + stiffness), 1.0 / (1.0 - min(stiffness, 0.75)), STIFFNESSES + 1)
    compliances = factors if loaded else np.ones(1)
    weights = np.linspace(0.0, weight_max, WEIGHTS + 1) if loaded else np.zeros(1)
    rows: list[tuple[Array, Array]] = []
    for compliance in compliances:
        rows.append(_hung(source.rod(float(compliance)), weights, gravity))
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


def _hung(rod: ModelRod, weights: Array, gravity: Array) -> tuple[Array, Array]:
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
