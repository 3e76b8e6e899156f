"""Observers of fixed gains, to be compared with: the force and the offset observer, each with several gains."""

import numpy as np
from numpy.typing import NDArray

from tendond.model.estimation.observer import ObserverState, observe, start_observer
from tendond.model.estimation.observer_gains import (
    INNOVATION_TIME,
    NOISE_FLOOR,
    NOISE_SHARE,
    ObserverGains,
    default_force_max,
)
from tendond.model.rods.general import GeneralRod, GeneralState

Array = NDArray[np.float64]

FACTORS = (0.3, 1.0, 3.0)
"""Of the force observer's usual gains."""

OFFSETS = (0.2, 0.5, 0.8)
"""Gains of the offset observer."""


class FixedGain:
    """One observer, with a model of its own state.

    Args:
        rod: the model. start: it at rest. gains: of the observer.
    """

    def __init__(self, rod: GeneralRod, start: GeneralState, gains: ObserverGains) -> None:
        self._rod, self._state, self._gains = rod, start, gains
        self._observer: ObserverState = start_observer(gains, start.position)

    @staticmethod
    def all_of(rod: GeneralRod, start: GeneralState) -> "list[FixedGain]":
        """Return the observers to be compared with."""
        return [FixedGain(rod, start, gains) for gains in all_gains(rod)]

    @property
    def tip(self) -> Array:
        """Estimated position of the tip [m], shape (3,)."""
        return self._state.position + self._observer.offset

    def advance(self, tensions: Array) -> None:
        """Advance the model by a cycle."""
        self._state = self._rod.step(self._state, tensions, tip_force=self._observer.tip_force)

    def correct(self, measured: Array | None) -> None:
        """Take a measured tip [m], shape (3,), or none."""
        self._observer = observe(self._gains, self._observer, self._rod, self._state, self._state.position, measured)


def all_gains(rod: GeneralRod) -> list[ObserverGains]:
    """Return the gains of all observers."""
    found = []
    for kind, factors in (("force", FACTORS), ("offset", OFFSETS)):
        for factor in factors:
            force = factor if kind == "force" else 1.0
            found.append(
                ObserverGains(
                    kind=kind,
                    period=rod.time_step,
                    delay=0.0,
                    integral=5.0 * force,
                    proportional=0.6 * force,
                    derivative=0.1 * force,
                    noise_floor=NOISE_FLOOR * rod.parameters.length,
                    noise_share=NOISE_SHARE,
                    innovation_time=INNOVATION_TIME,
                    force_max=default_force_max(rod.parameters, 0.1),
                    offset_gain=0.2 if kind == "force" else factor,
                )
            )
    return found
