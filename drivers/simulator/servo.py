"""Simulated servos between a command and the tendon's end; the defaults of the section are ideal."""

import math

import numpy as np
from numpy.typing import NDArray

from tendond.model.tendons.servo import ServoDynamics, advance, at_rest
from tendond.schemas.config.simulator import SimulatedServos

Array = NDArray[np.float64]


class SimulatedActuators:
    """One axis per tendon; positions [m] where displacement drives, tensions [N] where tension does.

    Args:
        section: [simulator.servo].
        period: between commands [s].
        start: present value, shape (n,).
        line: tension at which a servo stands [N], 0: none; speed without load [m/s].

    Attributes:
        stuck: indices of those that do not move.
    """

    def __init__(
        self, section: SimulatedServos, period: float, start: Array, line: tuple[float, float] = (0.0, 0.0)
    ) -> None:
        self._servo = ServoDynamics(
            section.rate, section.acceleration, section.lag, section.backlash, section.resolution, *line
        )
        self._period = period
        self._half_lag = math.exp(-0.5 * period / section.lag) if section.lag > 0.0 else 0.0
        self.stuck: list[int] = []
        self.stand(start)

    def stand(self, at: Array) -> None:
        """Stand still at `at`, without history."""
        self._states = [at_rest(place) for place in at.tolist()]
        self._end = at.copy()

    @property
    def ends(self) -> Array:
        """Position of the tendons' ends [m], or tension there [N], shape (n,)."""
        return self._end.copy()

    def follow_displacement(self, goal: Array, load: Array) -> tuple[Array, Array]:
        """Return the tendons' ends, mean and last of a period of moving to `goal` [m], shape (n,) each.

        Args:
            goal: [m].
            load: tension against them [N], shape (n,).
        """
        before = self._end
        for index, (place, pull) in enumerate(zip(goal.tolist(), load.tolist(), strict=True)):
            state = self._states[index]
            if index in self.stuck:
                state, place = state._replace(velocity=0.0), state.position
            self._states[index] = advance(self._servo, state, place, self._period, load=pull)
        self._end = np.array([state.end for state in self._states])
        return 0.5 * (before + self._end), self._end.copy()

    def follow_tension(self, goal: Array) -> tuple[Array, Array]:
        """Return the tensions in the middle and at the end of a period of pulling with `goal` [N], shape (n,) each.

        An ideal one has its goal at once.
        """
        goal = goal.copy()
        goal[self.stuck] = self._end[self.stuck]
        middle = goal + self._half_lag * (self._end - goal)
        self._end = goal + self._half_lag**2 * (self._end - goal)
        return middle, self._end.copy()
