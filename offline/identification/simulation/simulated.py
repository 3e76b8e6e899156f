"""A recording that can be computed with any parameters, in motion or at its rests: what a fit needs of it."""

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tendond.offline.identification.recordings.recording import Drive, Recording
from tendond.offline.identification.simulation.motion import TipMotion

Array = NDArray[np.float64]


class Simulated(Protocol):
    """A recording that can be computed with any parameters; stateless, for use by several threads.

    Attributes:
        recording: the recording; of rests with one pose each. drive: source of the tendons' ends.
        general: true where many sets of values are computed at once. motionless: names of parameters that the tip's
            motion does not depend on.
    """

    recording: Recording
    drive: Drive
    general: bool
    motionless: tuple[str, ...]

    def finer(self) -> "Simulated":
        """Return it with half the time step, where it has one."""

    def motion(self, values: Mapping[str, float]) -> TipMotion:
        """Compute the tip with values of all parameters, by name; SimulationError: no solution."""

    def motions(self, sets: Sequence[Mapping[str, float]]) -> list[TipMotion]:
        """Compute the tip for several sets of values; SimulationError: no solution."""

    def predicted_poses(self, motion: TipMotion, delay: float) -> Array:
        """Predict the recording's poses [m], shape (m, 3)."""

    def residuals(self, values: Mapping[str, float], motion: TipMotion, load_noise: float | None) -> list[Array]:
        """Compute model minus measurement in blocks, each with a row for each sample, in metres of the tip."""

    def shapes(self, loads: bool) -> list[tuple[int, int]]:
        """Return the shapes of the blocks of `residuals`, with or without the tensions."""

    def servos_apart(self, values: Mapping[str, float]) -> Array:
        """Compute the servos' modelled minus reported displacements [m], shape (r, moving)."""
