"""Loads on the simulated rod beside its own weight: a weight on the tip, still or swinging, and impacts."""

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from tendond.schemas.base import Vector3
from tendond.schemas.config_simulator import Impact, Weight

Array = NDArray[np.float64]

SUBSTEP = 5e-4
"""[s] Of the pendulum."""

AIR = 0.3
"""[1/s] Damping of the swing."""

SPREAD = 0.05
"""Half width of a push that is not at the tip, as a part of the rod's length: a hand, not a needle."""


class HungWeight:
    """A mass on the tip, by a string: gravity's pull, along the string's direction while it swings.

    A pendulum under a moving point, its string taut while it can be. The pull has the mass's weight and centripetal
    part; the tip's own acceleration sets it swinging but does not change the pull's size: the weight's inertia against
    the arm is left out (an arm of a few grams, explicitly coupled to ten times its mass, has no stable step).

    Args:
        section: [simulator.weight].
        gravity: [m/s^2].
        tip: where it is hung on [m], shape (3,).
    """

    def __init__(self, section: Weight, gravity: Vector3, tip: Array) -> None:
        self._section = section
        self._gravity = np.array(gravity)
        size = float(np.linalg.norm(self._gravity))
        self._down = self._gravity / size if size > 0.0 else np.zeros(3)
        self._tip, self._speed = tip.copy(), np.zeros(3)
        self._direction, self._turn = self._down.copy(), np.zeros(3)

    def force(self, time: float) -> Array:
        """On the tip at `time` [s]: [N], shape (3,)."""
        section = self._section
        if section.mass == 0.0 or time < section.time - 1e-9:
            return np.zeros(3)
        if section.string == 0.0:
            return section.mass * self._gravity
        pull = section.mass * (float(self._gravity @ self._direction) + section.string * float(self._turn @ self._turn))
        return max(0.0, pull) * self._direction

    def swing(self, tip: Array, period: float) -> None:
        """Move on by `period` [s] while the tip moves to `tip` [m], shape (3,)."""
        section = self._section
        if section.mass == 0.0 or section.string == 0.0:
            return
        speed = (tip - self._tip) / period
        acceleration = (speed - self._speed) / period
        self._tip, self._speed = tip.copy(), speed
        steps = max(1, math.ceil(period / SUBSTEP))
        dt = period / steps
        d, turn = self._direction, self._turn
        for _ in range(steps):
            across = (self._gravity - acceleration) - d * float(d @ (self._gravity - acceleration))
            turn = turn + dt * (across / section.string - AIR * turn)
            d = d + dt * turn
            d = d / float(np.linalg.norm(d))
            turn = turn - d * float(d @ turn)
        self._direction, self._turn = d, turn


def impacts_at(impacts: Iterable[Impact], time: float) -> list[tuple[float, Array]]:
    """Place (part of the length) and force [N], shape (3,), of the impacts that act at `time` [s]."""
    return [
        (impact.place, np.array(impact.force))
        for impact in impacts
        if impact.time - 1e-9 <= time < impact.time + impact.duration - 1e-9
    ]
