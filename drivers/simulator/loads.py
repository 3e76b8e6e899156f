"""Loads on the simulated rod beside its own weight: a weight on the tip, still or swinging, and impacts."""

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from tendond.schemas.base import Vector3
from tendond.schemas.config.simulator import Impact, Weight

Array = NDArray[np.float64]

SUBSTEP = 5e-4
"""Time step of the swinging weight [s]."""

STRING_STIFFNESS = 100.0
STRING_DAMPING = 1.5
"""Stiffness [N/m] and damping [N s/m] of the string, which stretches by 5 mm under 50 g: soft enough to couple the
weight to the rod with forces of the last step (a stiff one would need the weight inside the rod's equations)."""

SPREAD = 0.05
"""Half width of a push that is not at the tip, as a fraction of the rod's length: that of a hand."""


class HungWeight:
    """A mass on the tip: fixed to it, a bob on an elastic string that pulls where it swings, or gravity's pull alone.

    Args:
        section: [simulator.weight].
        gravity: [m/s^2].
        tip: point on which it is hung [m], shape (3,).
    """

    def __init__(self, section: Weight, gravity: Vector3, tip: Array) -> None:
        self._section = section
        self._gravity = np.array(gravity)
        size = float(np.linalg.norm(self._gravity))
        self._down = self._gravity / size if size > 0.0 else np.zeros(3)
        self._hang(tip)

    def _hang(self, tip: Array) -> None:
        """Place the weight at rest below `tip`."""
        section = self._section
        stretch = section.mass * float(np.linalg.norm(self._gravity)) / STRING_STIFFNESS
        self._tip, self._tip_speed = tip.copy(), np.zeros(3)
        self._bob, self._speed = tip + (section.string + stretch) * self._down, np.zeros(3)

    def hangs(self, time: float) -> bool:
        """Return whether it hangs on the tip at `time` [s]."""
        return self._section.mass > 0.0 and time >= self._section.time - 1e-9

    def body(self, time: float) -> float:
        """Return the mass fixed to the tip at `time` [kg], which is accelerated with it."""
        section = self._section
        return section.mass if self.hangs(time) and section.string == 0.0 and not section.force_only else 0.0

    def force(self, time: float, period: float) -> Array:
        """Return the force on the tip beyond that of `body`, over the `period` [s] from `time` [s]: [N], shape (3,)."""
        section = self._section
        if not self.hangs(time) or self.body(time) > 0.0:
            return np.zeros(3)
        if section.string == 0.0:
            return section.mass * self._gravity
        # At the tip half a step later: a force from the beginning of the step would add energy.
        return self._pull(self._tip + 0.5 * period * self._tip_speed, self._tip_speed)

    def swing(self, time: float, tip: Array, period: float) -> None:
        """Advance by `period` [s] while the tip moves to `tip` [m], shape (3,)."""
        section = self._section
        if section.mass == 0.0 or section.string == 0.0:
            return
        if time < section.time - 1e-9:
            self._hang(tip)
            return
        steps = max(1, math.ceil(period / SUBSTEP))
        dt, start = period / steps, self._tip
        self._tip_speed = (tip - start) / period
        for step in range(steps):
            at = start + (step + 0.5) / steps * (tip - start)
            self._speed = self._speed + dt * (self._gravity - self._pull(at, self._tip_speed) / section.mass)
            self._bob = self._bob + dt * self._speed
        self._tip = tip.copy()

    def _pull(self, tip: Array, tip_speed: Array) -> Array:
        """Return the force of the string on the tip [N], shape (3,); zero while slack."""
        string = self._bob - tip
        length = float(np.linalg.norm(string))
        stretch = length - self._section.string
        if stretch <= 0.0:
            return np.zeros(3)
        along = string / length
        pull = STRING_STIFFNESS * stretch + STRING_DAMPING * float(along @ (self._speed - tip_speed))
        return max(0.0, pull) * along


def impacts_at(impacts: Iterable[Impact], time: float) -> list[tuple[float, Array]]:
    """List position (fraction of the length) and force [N], shape (3,), of the impacts active at `time` [s]."""
    return [
        (impact.place, np.array(impact.force))
        for impact in impacts
        if impact.time - 1e-9 <= time < impact.time + impact.duration - 1e-9
    ]
