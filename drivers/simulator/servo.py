"""Simulated servos between a command and the tendon's end; the defaults of the section are ideal."""

import math

import numpy as np
from numpy.typing import NDArray

from tendond.drivers.simulator.friction import between
from tendond.schemas.config.simulator import SimulatedServos

Array = NDArray[np.float64]


class SimulatedActuators:
    """One axis per tendon; positions [m] where displacement drives, tensions [N] where tension does.

    Args:
        section: [simulator.servo].
        period: between commands [s].
        start: present value, shape (n,).

    Attributes:
        tension: tension that they pull with where tension drives [N], shape (n,).
        stuck: indices of those that do not move.
    """

    def __init__(self, section: SimulatedServos, period: float, start: Array) -> None:
        self._section = section
        self._period = period
        self._lag_factor = math.exp(-period / section.lag) if section.lag > 0.0 else 0.0
        self.stuck: list[int] = []
        self.stand(start)

    def stand(self, at: Array) -> None:
        """Stand still at `at`, without history."""
        self._profile = at.copy()
        self._speed = np.zeros_like(at)
        self._shaft = at.copy()
        self._end = at.copy()

    @property
    def tension(self) -> Array:
        return self._shaft.copy()

    @property
    def ends(self) -> Array:
        """Position of the tendons' ends [m] (or tension at the rod [N]), shape (n,)."""
        return self._end.copy()

    def follow_displacement(self, goal: Array) -> Array:
        """Return the displacement of the tendons' ends after a period of moving to `goal` [m], shape (n,)."""
        section, period = self._section, self._period
        if section.resolution > 0.0:
            goal = section.resolution * np.round(goal / section.resolution)
        goal = self._stuck_at(self._profile, goal)
        distance = goal - self._profile
        speed = distance / period
        if section.acceleration > 0.0:
            # Not faster than it can still brake in whole periods, nor than it can change its speed in one.
            change = section.acceleration * period
            braking = change * (np.sqrt(0.25 + 2.0 * np.abs(distance) / (change * period)) - 0.5)
            speed = np.clip(speed, -braking, braking)
            speed = np.clip(speed, self._speed - change, self._speed + change)
        if section.rate > 0.0:
            speed = np.clip(speed, -section.rate, section.rate)
        self._profile = self._profile + speed * period
        self._speed = speed
        self._shaft = self._profile + self._lag_factor * (self._shaft - self._profile)
        play = 0.5 * section.backlash
        self._end = np.clip(self._end, self._shaft - play, self._shaft + play)
        return self._end.copy()

    def follow_tension(self, goal: Array, ratio: float = 1.0) -> Array:
        """Return the tensions at the rod after a period of pulling with `goal` [N], shape (n,): lag, then friction.

        Args:
            goal: [N].
            ratio: see `friction.grip`.
        """
        goal = self._stuck_at(self._shaft, goal)
        self._shaft = goal + self._lag_factor * (self._shaft - goal)
        self._end = between(self._end, self._shaft, ratio)
        return self._end.copy()

    def _stuck_at(self, place: Array, goal: Array) -> Array:
        """Return `goal`, but `place` for those that are stuck, which stop at once."""
        goal = goal.copy()
        goal[self.stuck] = place[self.stuck]
        self._speed[self.stuck] = 0.0
        return goal
