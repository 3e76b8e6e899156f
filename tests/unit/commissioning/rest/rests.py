"""Rests of the paper's robot as a camera would see them, right and wrong."""

import math

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.commissioning.rest_grid import configured_rests
from tendond.daemon.control.commissioning.rests import RestFamily, Tolerances
from tendond.daemon.control.commissioning.rotations import turn_by
from tendond.model.numerics.rotation import quaternion
from tendond.model.rods.selection import rod_from_section
from tendond.schemas.base import Quaternion
from tendond.schemas.config.rig import RigConfig

Array = NDArray[np.float64]
CONFIG = RigConfig()
ROD = rod_from_section(CONFIG.rod, CONFIG.loop.period)
_FAMILY = configured_rests(CONFIG, ROD.parameters)
assert _FAMILY is not None
FAMILY: RestFamily = _FAMILY
TILT, OFFSET, MARKERS = 0.03, 0.004, 0.2
LENGTH = 0.5


def rest(
    stiffness: float = 1.0, weight: float = 0.0, tilt: Array | None = None, offset: Array | None = None
) -> tuple[Array, Array]:
    """Tip position [m] and rotation of an arm at rest: E against the model's, weight [kg], base turned, displaced."""
    turn = np.eye(3) if tilt is None else turn_by(tilt)
    gravity = turn.T @ np.array(CONFIG.rod.gravity)
    x, y, z = gravity.tolist()
    section = CONFIG.rod.model_copy(
        update={"youngs_modulus": stiffness * CONFIG.rod.youngs_modulus, "gravity": (x, y, z)}
    )
    rod = rod_from_section(section, CONFIG.loop.period)
    tip = rod.tip(rod.solve_static(np.zeros(4), tip_force=weight * gravity))
    position = turn @ tip.position
    return (position if offset is None else position + offset), turn @ tip.rotation


def degrees(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Array:
    """Rotation vector [rad], shape (3,)."""
    return np.radians([x, y, z])


def as_quaternion(rotation: Array) -> Quaternion:
    return quaternion(rotation)


def unit(random: np.random.Generator) -> Array:
    """A direction, all alike, shape (3,)."""
    vector = random.normal(size=3)
    return vector / math.hypot(*vector.tolist())


def family(*positions: tuple[float, float, float]) -> RestFamily:
    """Rests of upright tips, each with a weight and a stiffness of its own."""
    places = np.array(positions or ((0.0, 0.0, LENGTH),))
    count = len(places)
    index = np.arange(count, dtype=np.float64)
    return RestFamily(
        LENGTH, Tolerances(TILT, OFFSET, MARKERS), 0.01 * index, 1.0 + index, places,
        np.tile(np.eye(3), (count, 1, 1)),
    )  # fmt: skip
