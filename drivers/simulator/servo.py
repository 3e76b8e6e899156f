"""Simulated servos between a command and the tendon's end; the defaults of the section are ideal."""

import math

import numpy as np
from numpy.typing import NDArray

from tendond.drivers.simulator.friction import between
from tendond.model.tendons.servo import ServoDynamics, advance, at_rest
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
        self._servo = ServoDynamics(
            section.rate, section.acceleration, section.lag, section.backlash, section.resolution
        )
        self._period = period
        self._lag_factor = math.exp(-period / section.lag) if section.lag > 0.0 else 0.0
        self.stuck: list[int] = []
        self.stand(start)

    def stand(self, at: Array) -> None:
        """Stand still at `at`, without history."""
        self._states = [at_rest(place) for place in at.tolist()]
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
        for index, place in enumerate(goal.tolist()):
            state = self._states[index]
            if index in self.stuck:
                state, place = state._replace(velocity=0.0), state.position
            self._states[index] = advance(self._servo, state, place, self._period)
        self._end = np.array([state.end for state in self._states])
        return self._end.copy()

    def follow_tension(self, goal: Array, ratio: float = 1.0) -> Array:
        """Return the tensions at the rod after a period of pulling with `goal` [N], shape (n,): lag, then friction.

        Args:
            goal: [N].
            ratio: see `friction.grip`.
        """
        goal = goal.copy()
        goal[self.stuck] = self._shaft[self.stuck]
        self._shaft = goal + self._lag_factor * (self._shaft - goal)
        self._end = between(self._end, self._shaft, ratio)
        return self._end.copy()
