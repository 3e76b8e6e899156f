"""Ghost of the target: the shape in which the arm rests with its tip there, for display."""

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tendond.model import ModelError
from tendond.model.rods.interface import ModelRod
from tendond.schemas.base import Vector3
from tendond.schemas.config.rig import RigConfig

Array = NDArray[np.float64]

STEPS = 40
"""Tensions of each tendon of the bending plane whose rests are computed: neighbours are then a few hundredths of the
length apart, between which shapes are interpolated."""

TOLERANCE = 0.03
"""Largest distance of the target from the tips at rest, in lengths of the arm; beyond it no ghost is drawn: the target
is no rest of this plane, as those in space."""

POINTS = 30
DECIMALS = 4


class Ghost:
    """Shapes at rest under the tension of either tendon of the bending plane.

    Args:
        rod: the model's. config: of the rig.
    """

    def __init__(self, rod: ModelRod, config: RigConfig) -> None:
        self._reach = TOLERANCE * config.rod.backbone_length
        self._branches = [
            _branch(rod, tendon, config.limits.tension_max)
            for tendon in (config.control.agonist, config.control.antagonist)
            if tendon is not None
        ]

    def shape(self, target: Vector3) -> list[list[float]] | None:
        """Return points of the backbone, base to tip [m], shape (n, 3), with the tip near a target [m]; else none."""
        nearest, found = self._reach, None
        for branch in self._branches:
            for first, second in pairwise(branch):
                way = second[-1] - first[-1]
                size = float(way @ way)
                part = 0.0 if size == 0.0 else min(1.0, max(0.0, float((np.array(target) - first[-1]) @ way) / size))
                shape = first + part * (second - first)
                distance = math.dist(shape[-1], target)
                if distance < nearest:
                    nearest, found = distance, shape
        if found is None:
            return None
        points: list[list[float]] = np.round(found, DECIMALS).tolist()
        return points


def _branch(rod: ModelRod, tendon: int, tension_max: float) -> list[Array]:
    """Return the shapes under rising tension of a tendon, each shape (POINTS, 3), as far as they are found."""
    shapes: list[Array] = []
    state = None
    for tension in np.linspace(0.0, tension_max, STEPS):
        tensions = np.zeros(rod.parameters.tendon_count)
        tensions[tendon] = tension
        try:
            state = rod.solve_static(tensions, start=state)
        except ModelError:
            break
        shapes.append(rod.curve(state, POINTS))
    return shapes
