"""The simulated rod's description in the truth now and then: a controller compares it with its own model."""

import math

from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.rod.compare import figures
from tendond.schemas.messages import SimulatorTruth

EVERY_SECONDS = 1.0

CYCLES = 2
"""Cycles of the controller for which each truth has it: of those that come within a cycle it reads the newest."""


class Introduction:
    """Puts the figures of [simulator.rod] into some truths.

    Args:
        config: configuration of the rig.
    """

    def __init__(self, config: RigConfig) -> None:
        period = config.simulator.period
        self._figures = figures(config.simulator.rod)
        self._every = max(1, round(EVERY_SECONDS / period))
        self._part = math.ceil(CYCLES * config.loop.period / period)

    def added_to(self, truth: SimulatorTruth) -> SimulatorTruth:
        """Return the truth, with the figures where they are due."""
        if truth.seq % self._every >= self._part:
            return truth
        return truth.model_copy(update={"rod": self._figures})
