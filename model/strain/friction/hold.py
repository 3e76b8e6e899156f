"""Friction held: the tendons with the ratios of tensions along them that a state has, for derivatives and stability.

With the profile T(s) / T(0) as a weight on the path, a tendon is one with a single tension again. That is the tendon
that goes on to slide, or to stick, as it does; exact derivatives of Coulomb's law would be zero wherever it sticks.
"""

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.model.numerics.parked import park
from tendond.model.strain.layout import Layout
from tendond.model.strain.stepping.scratch import Loads, Scratch

Array = NDArray[np.float64]


def without_friction(layout: Layout) -> Layout:
    """Return the same robot, in the same arrays, whose tendons do not rub."""
    return park(layout._replace(friction=np.zeros_like(layout.friction)))


def hold_profiles(layout: Layout, pulls: Array | None, *works: Scratch) -> None:
    """Weight the paths of the tendons that rub by the tensions along them; none: by 1.

    Args:
        layout: of the robot, with its friction. pulls: of a state, shape (F, 1 + Q). works: whose paths these are.
    """
    rubbing = np.flatnonzero(layout.friction > 0.0)
    if len(rubbing) == 0:
        return
    weight = layout.weight[:, rubbing]
    if pulls is not None:
        taut = pulls[:, 0] > 0.0
        weight = weight * np.where(taut, pulls[:, 1:].T / np.where(taut, pulls[:, 0], 1.0), 1.0)
    for work in works:
        for paths in (work.paths_before, work.paths_after):
            paths.routes.reshape(len(weight), 5, -1)[:, 4, rubbing] = weight


def hold(layout: Layout, loads: Loads, pulls: Array | None, *works: Scratch) -> Loads:
    """Weight the paths as `hold_profiles` does; return loads in which a state's tensions pull at the servos' ends."""
    hold_profiles(layout, pulls, *works)
    rubbing = np.flatnonzero(layout.friction > 0.0)
    if len(rubbing) == 0:
        return loads
    tension, driven = loads.tension.copy(), loads.driven.copy()
    tension[rubbing], driven[rubbing] = 0.0 if pulls is None else pulls[:, 0], False
    return loads._replace(tension=tension, driven=driven)


def check_drive(layout: Layout, loads: Loads) -> None:
    """Refuse tendons that rub and are driven by displacement, of which no derivatives are known.

    Raises:
        ParameterError: there is one.
    """
    wrong = np.flatnonzero(loads.driven & (layout.friction > 0.0))
    if len(wrong) > 0:
        raise ParameterError(
            f"linearise: tendon {wrong[0]} has friction and is driven by displacement: drive it by tension, or set its"
            " friction to 0"
        )
