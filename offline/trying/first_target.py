"""A first target for a robot: well within its workspace, and what it takes to get there."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.reference.equilibria import rest_at
from tendond.daemon.control.reference.planar import PLANES
from tendond.daemon.control.reference.strain import bending_strain, yield_strain
from tendond.daemon.errors import TargetError
from tendond.model.rod.static_curve import StaticCurve, static_curve
from tendond.model.rods.interface import ModelRod
from tendond.model.rods.selection import model_rod
from tendond.schemas.config.rig import RigConfig

Array = NDArray[np.float64]

TURN = math.radians(45.0)
"""Turn of the tip from its rest up to a first target [rad]: a bend that is plain to see, far from the fold, which lies
beyond 90 degrees. Chosen."""

PART = 0.5
"""Part of limits.tension_max, of the strain that the backbone bears, and of the furthest tip across, that a first
target takes. Chosen."""

STILL = 0.01
"""Motion of the tip across under limits.tension_max that is none, of the robot's length."""

RESERVE = 2.5
"""Tension that a robot without limits.tension_max of its own gets, by that of its first target. Chosen: a push on the
tip, and a target twice as far, are still within it."""


SERVO_RESERVE = 5.0
"""The same for a robot behind servos: the probe stops at commissioning.tension_fraction of the limit, and what servos
report has ticks, and swings with the arm. Wire of 0.3 m and 1 mm, 2 % of damping, tendons of 15 N/mm: the probe of
0.1 N sees 0.8 N, more than its bound with 2.5, less than that with 5."""


@dataclass(frozen=True)
class FirstTarget:
    """A first target in the bending plane.

    Attributes:
        across: x (or y) of the tip [m]. tension: of the agonist there [N]. turn: of the tip from its rest [rad].
    """

    across: float
    tension: float
    turn: float

    def tension_max(self, reserve: float = RESERVE) -> float:
        """Return a limit of tension with a reserve [N], rounded up."""
        return rounded_up(reserve * self.tension)


def first_target(config: RigConfig) -> FirstTarget:
    """Choose a target on the curve of the resting tip under the agonist.

    Raises:
        TargetError: the agonist does not move the tip in the plane.
        ModelError: a robot that cannot be, or that has no equilibrium.
    """
    config = config.with_own_rates()
    rod, axes = model_rod(config), PLANES[config.control.plane]
    curve = static_curve(rod, config.control.agonist, config.limits.tension_max, axes)
    across = curve.spline(curve.arc)[:, 0]
    if np.ptp(across) < STILL * config.rod.backbone_length:
        raise TargetError(
            f"control.agonist = {config.control.agonist}: that tendon hardly bends the robot in plane "
            f"'{config.control.plane}': name another, or a larger limits.tension_max"
        )
    index = _index(config, rod, curve, across)
    return FirstTarget(
        _rounded(float(across[index]), config.rod.backbone_length),
        float(curve.tension[index]),
        float(abs(curve.angle[index] - curve.angle[0])),
    )


def rounded_up(value: float) -> float:
    """Round up to two digits: 4.13 becomes 4.2."""
    step = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{math.ceil(value / step - 1e-9) * step:.2g}")


def _rounded(value: float, length: float) -> float:
    """Round a place to a half percent of the robot's length or less, for people."""
    step = 10.0 ** math.floor(math.log10(0.01 * length))
    return round(round(value / step) * step, 9) + 0.0


def _index(config: RigConfig, rod: ModelRod, curve: StaticCurve, across: Array) -> int:
    """Return the index of the curve at which the first of the parts is reached."""
    way = np.abs(across - across[0])
    reached = (
        (np.abs(curve.angle - curve.angle[0]) >= TURN)
        | (curve.tension >= PART * config.limits.tension_max)
        | (way >= PART * way.max())
    )
    index = max(int(np.argmax(reached)), 1)
    limit, _ = yield_strain(config.rod)
    while limit is not None and index > 1:
        state = rest_at(config, rod, curve, float(curve.arc[index]))
        if bending_strain(config.rod, rod, [state]) <= PART * limit:
            break
        index = max(1, (9 * index) // 10)
    return index
