"""Rests of a recording with given parameters: the general rod's equilibria, one after the other as they were taken.

Each rest is found from the one before, along the path of the tendons' ends: friction, backlash and a robot with several
equilibria remember it.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.state import StrainState
from tendond.offline.identification.parameters import DYNAMIC
from tendond.offline.identification.recordings.recording import Drive, Recording
from tendond.offline.identification.recordings.rests import Rests, find_rests
from tendond.offline.identification.simulation.general import robot_with, tensions_at
from tendond.offline.identification.simulation.motion import RELEASED, SimulationError, TipMotion, shown
from tendond.offline.identification.simulation.simulate import PULLING, true_ends

Array = NDArray[np.float64]

PATH_STEP = 0.005
"""Largest step of a tendon between two equilibria [m], so that each is near the one before."""


class StaticSimulation:
    """A recording's rests, which can be computed with any parameters; see `Simulated`.

    Args:
        recording: the recording. drive: source of the tendons' ends.
        rests: of the recording; none: they are found.

    Raises:
        DataError: too few rests.
    """

    general = False
    motionless: tuple[str, ...] = DYNAMIC

    def __init__(self, recording: Recording, drive: Drive, rests: Rests | None = None) -> None:
        found = find_rests(recording, drive) if rests is None else rests
        self.drive = drive
        self.rests = found
        period = float(np.median(np.diff(found.times)))
        self.recording = replace(
            recording, pose_times=found.times, position=found.position, noise=found.noise, period=period
        )

    def finer(self) -> "StaticSimulation":
        """Return itself: it has no time step."""
        return self

    def motion(self, values: Mapping[str, float]) -> TipMotion:
        """Compute the tips at rest.

        Args:
            values: values of all parameters, by name.

        Raises:
            SimulationError: no solution.
        """
        path = self.recording.path
        try:
            rod = StrainRod(robot_with(self.recording, values))
        except ParameterError as error:
            raise SimulationError(f"{path}: {error}") from error
        tips, tensions, next_rest = np.empty((len(self.rests), 3)), np.empty(self.rests.pulled.shape), 0
        state: StrainState | None = None
        before: Array | None = None
        for k, ends in enumerate(self._driven(values)):
            for row in _between(before, ends):
                try:
                    state = rod.solve_static(rod.loads(displacement=row), state)
                except ConvergenceError as error:
                    raise SimulationError(f"{path}: no rest with {shown(values)}: {error}") from error
            before = ends
            if next_rest < len(self.rests) and self.rests.row[next_rest] == k:
                assert state is not None
                tips[next_rest], tensions[next_rest] = rod.tip(state)[0], tensions_at(rod, state, ends)
                next_rest += 1
        return TipMotion(0.0, 0.0, tips, tensions)

    def motions(self, sets: Sequence[Mapping[str, float]]) -> list[TipMotion]:
        """Compute the tips at rest for several sets of values; SimulationError: no solution."""
        return [self.motion(values) for values in sets]

    def _driven(self, values: Mapping[str, float]) -> Array:
        """Return the tendons' ends along the path [m], shape (q, n): behind the backlash, true, or released."""
        ends = self.rests.path.copy()
        if self.drive == "command" and values["backlash"] > 0.0:
            play, end = 0.5 * values["backlash"], ends[0].copy()
            for k, armed in enumerate(self.rests.armed):
                end = np.clip(end, ends[k] - play, ends[k] + play) if armed else ends[k].copy()
                ends[k] = end
        ends = true_ends(ends, values)
        ends[~self.rests.armed] = RELEASED
        return ends

    def predicted_poses(self, motion: TipMotion, delay: float) -> Array:
        """Return the tips at rest [m], shape (k, 3); a delay does not change them."""
        return motion.tips

    def residuals(self, values: Mapping[str, float], motion: TipMotion, load_noise: float | None) -> list[Array]:
        """Compute model minus measurement: the tips, shape (k, 3), and the tensions, see `Simulation.residuals`."""
        found = [motion.tips - self.recording.position]
        if load_noise is not None:
            scale = max(self.recording.noise, 1e-5) / load_noise
            pulled = self.rests.pulled
            apart = np.where(pulled > PULLING * load_noise, scale * (motion.tensions - pulled), 0.0)
            found.append(apart)
        return found

    def shapes(self, loads: bool) -> list[tuple[int, int]]:
        """Return the shapes of the blocks of `residuals`, with or without the tensions."""
        return [(len(self.rests), 3), *([self.rests.pulled.shape] if loads else [])]

    def servos_apart(self, values: Mapping[str, float]) -> Array:
        """Return no differences of the servos' displacements: rests say nothing of their motion, shape (0, 0)."""
        return np.zeros((0, 0))


def _between(before: Array | None, ends: Array) -> list[Array]:
    """Return the ends on the way from those before [m], in steps of `PATH_STEP`; a tendon let go is let go at once."""
    if before is None or min(float(before.min()), float(ends.min())) <= 0.5 * RELEASED:
        return [ends]
    count = max(1, math.ceil(float(np.abs(ends - before).max()) / PATH_STEP))
    return [before + (ends - before) * part / count for part in range(1, count + 1)]
