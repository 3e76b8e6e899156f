"""Tension along tendons that rub, their stretch, and their ends, by what a person asks for."""

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.model.strain.friction.cells import find_cells
from tendond.model.strain.friction.grip import empty_grip
from tendond.model.strain.layout import Layout
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.state import StrainState
from tendond.model.strain.tendons import empty_paths, find_paths

Array = NDArray[np.float64]


def tension_along(rod: StrainRod, state: StrainState, tendon: int) -> tuple[Array, Array]:
    """Return arc lengths from the base to a tendon's end [m], and the tension there [N], each of shape (k,).

    Up to its end the tension goes on to change as before it.

    Raises:
        ParameterError: a tendon without friction, whose tension is the same everywhere.
    """
    rubbing = np.flatnonzero(rod.layout.friction > 0.0)
    if tendon not in rubbing:
        raise ParameterError(f"tendon {tendon} has no friction: its tension is the same everywhere")
    row = int(np.searchsorted(rubbing, tendon))
    places = _places(rod.layout)
    count = int(np.count_nonzero(rod.layout.weight[:, tendon]))
    s = np.concatenate(([0.0], places[:count], [rod.robot.tendons[tendon].end]))
    pulls = np.zeros(count + 1) if state.pulls is None else state.pulls[row, : count + 1]
    last = 0.0
    if pulls[-1] > 0.0:
        last = pulls[-1] * (pulls[-1] / pulls[-2]) ** ((s[-1] - s[-2]) / (s[-2] - s[-3]))
    return s, np.append(pulls, last)


def cell_shortening(rod: StrainRod, state: StrainState) -> Array:
    """Return less the length of path that each tendon point stands for [m], shape (F, Q)."""
    paths, grip = empty_paths(rod.layout), empty_grip(rod.layout)
    find_paths(rod.layout, state.strain, paths)
    find_cells(rod.layout, paths, grip, grip.after)
    return grip.after.shortening


def stretches(layout: Layout, pulls: Array | None, tensions: Array, stiffness: Array) -> Array:
    """Return by how much each tendon is longer than without tension [m], shape (m,).

    Args:
        layout: of the robot. pulls: of a state, shape (F, 1 + Q). tensions: at the servos' ends [N], shape (m,).
        stiffness: of each tendon [N/m], shape (m,).
    """
    found = tensions / stiffness
    if pulls is not None:
        rubbing = np.flatnonzero(layout.friction > 0.0)
        found[rubbing] = np.einsum("fj,jf->f", pulls[:, 1:], layout.compliance[:, rubbing])
    return np.asarray(found)


def _places(layout: Layout) -> Array:
    """Arc lengths of the tendon points [m], shape (Q,)."""
    steps = layout.reach.sum(axis=1)
    steps[0] *= steps[1]
    return np.cumsum(steps)
