"""Friction of the tendons, for those who hold either rod: the shooting rod has none."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tendond.model.rods.general import GeneralRod, GeneralState
from tendond.model.rods.interface import ModelRod, ModelState

Array = NDArray[np.float64]


def without_friction(rod: ModelRod) -> ModelRod:
    """Return the rod with tendons that do not rub: at rest it has one shape under given tensions, however it got there.

    That shape lies between those with friction, of tendons that were pulled and that were let out.
    """
    if not isinstance(rod, GeneralRod) or not any(one.friction > 0.0 for one in rod.robot.tendons):
        return rod
    tendons = tuple(replace(one, friction=0.0) for one in rod.robot.tendons)
    return GeneralRod(replace(rod.robot, tendons=tendons), rod.time_step, rod.compliance)


def end_tensions(rod: ModelRod, state: ModelState) -> Array:
    """Return the tensions where the tendons are fixed to the robot [N], shape (n,); at the servos they are the state's.

    The difference is what friction along the tendon holds: less at the tip where it is pulled, more where it is let
    out.
    """
    if isinstance(rod, GeneralRod) and isinstance(state, GeneralState):
        return rod.end_tensions(state)
    return np.asarray(state.tensions, dtype=np.float64).copy()
