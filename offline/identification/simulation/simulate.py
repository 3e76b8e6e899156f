"""Simulation of a recording with given parameters: the displacement-driven rod, offline.

Servos follow the commands with a first-order lag (or their own reports are used) and pull on elastic tendons; poses of
the tip arrive a delay later. Where the torque is off the tendons are slack. The rod starts at rest, as the arm did. A
known weight is a rigid body on the tip, with the inertia of a brass ball.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from tendond.model.rods.selection import solver_of
from tendond.offline.identification.recordings.recording import Drive, Recording
from tendond.offline.identification.simulation.general import general_motions
from tendond.offline.identification.simulation.motion import RELEASED, TipMotion
from tendond.offline.identification.simulation.servos import reported_ends, settled_reports, tendon_ends
from tendond.offline.identification.simulation.shooting import shooting_motion

Array = NDArray[np.float64]


TIME_STEP = 0.005
"""Maximum time step [s]. The controller's 10 ms shift the rod's first frequency by a percent, an error of the density.

Commands change between two steps: the tendons' ends are those of a step's middle.
"""


TRAVEL = 0.002
"""Travel [m] above which a servo's reports are used: the position of one that hardly moves is lost in its backlash."""


PULLING = 3.0
"""Tension, in units of its noise, above which it is used: that of a slack tendon cannot fall below zero."""


class Simulation:
    """A recording that can be simulated with any parameters; stateless, for use by several threads.

    Args:
        recording: the recording.
        drive: source of the tendons' ends.
        time_step: maximum time step [s].
        general: whether the general rod is needed, whatever the configuration asks for.

    Attributes:
        general: true where the rod is the general one, so that many sets of values are simulated at once.
        motionless: names of parameters that the rod's motion does not depend on: their derivatives need no simulation.
    """

    def __init__(self, recording: Recording, drive: Drive, time_step: float = TIME_STEP, general: bool = False) -> None:
        self.recording = recording
        self.drive = drive
        self.general = general or solver_of(recording.config.rod, recording.config.control.solver) == "general"
        self.motionless = MOTIONLESS[drive]
        period = recording.period
        self.step = period / math.ceil(period / time_step - 1e-9)
        last = max(recording.duration, float(recording.pose_times[-1]))
        self._ends_at: Array = np.asarray(
            self.step * (np.arange(math.ceil(last / self.step) + 2) + 0.5), dtype=np.float64
        )
        now = np.searchsorted(recording.times, self._ends_at, side="right") - 1
        self._armed = recording.armed[now]
        edges = np.flatnonzero(np.diff(self._armed.astype(int)))
        stretches = list(zip(np.r_[0, edges + 1], np.r_[edges + 1, len(now)], strict=True))
        self.reports_count = settled_reports(recording)
        reported = recording.reported[self.reports_count]
        travel = np.ptp(reported, axis=0) if len(reported) else np.zeros(recording.command.shape[1])
        self._moving = np.flatnonzero(travel > TRAVEL)
        self._ends = (
            reported_ends(recording, self._ends_at, stretches, self.step)
            if drive == "measured"
            else np.zeros_like(recording.command[now])
        )

    def finer(self) -> "Simulation":
        """Return the simulation with half the time step."""
        return Simulation(self.recording, self.drive, 0.5 * self.step, self.general)

    def motion(self, values: Mapping[str, float]) -> TipMotion:
        """Simulate the rod's motion.

        Args:
            values: values of all parameters, by name.

        Raises:
            SimulationError: no solution; with the time.
        """
        return self.motions([values])[0]

    def motions(self, sets: Sequence[Mapping[str, float]]) -> list[TipMotion]:
        """Simulate the rod's motion for several sets of values, in one batch where the rod is the general one.

        Raises:
            SimulationError: no solution.
        """
        ends = np.stack([self._driven(values) for values in sets], axis=1)
        starts = ends[0] if self._armed[0] else np.full(ends.shape[1:], RELEASED)
        if self.general:
            return general_motions(self.recording, sets, starts, ends, self.step)
        return [
            shooting_motion(self.recording, values, starts[i], ends[:, i], self.step) for i, values in enumerate(sets)
        ]

    def _driven(self, values: Mapping[str, float]) -> Array:
        """Compute the displacements of the tendons' ends in the middle of each step [m], shape (steps, n)."""
        measured = self.drive == "measured"
        ends = self._ends if measured else tendon_ends(self.recording, self._ends_at, values["lag"], values["backlash"])
        ends = true_ends(ends, values)
        ends[~self._armed] = RELEASED
        return ends

    def predicted_poses(self, motion: TipMotion, delay: float) -> Array:
        """Predict the recording's poses [m], shape (m, 3): the tip `delay` [s] before, by cubic interpolation."""
        return motion.at(self.recording.pose_times - delay)

    def residuals(self, values: Mapping[str, float], motion: TipMotion, load_noise: float | None) -> list[Array]:
        """Compute model minus measurement, a row for each sample, in metres of the tip.

        Args:
            values: values of all parameters, by name.
            motion: the motion with these values, except those that it does not depend on.
            load_noise: noise of the reported tensions [N]; none: they are not used.

        Returns:
            Blocks: of the poses, shape (m, 3); where `drive` is 'measured', of the servos that move, shape (r, moving);
            where loads are used, of the tensions, in units of their noise times the poses' noise, shape (r, n).
        """
        recording = self.recording
        found = [self.predicted_poses(motion, values["delay"]) - recording.position]
        if self.drive == "measured":
            found.append(self.servos_apart(values))
        if load_noise is not None:
            count = self.reports_count
            ahead = recording.report_times[count] - motion.first
            rows = np.ceil(ahead / motion.step - 1e-6).astype(np.intp) - 1
            scale = max(recording.noise, 1e-5) / load_noise
            tensions = motion.tensions[np.clip(rows, 0, len(motion.tensions) - 1)]
            pulled = recording.pulled[count]
            found.append(np.where(pulled > PULLING * load_noise, scale * (tensions - pulled), 0.0))
        return found

    def shapes(self, loads: bool) -> list[tuple[int, int]]:
        """Return the shapes of the blocks of `residuals`, with or without the tensions."""
        count = int(np.count_nonzero(self.reports_count))
        found = [(len(self.recording.pose_times), 3)]
        if self.drive == "measured":
            found.append((count, len(self._moving)))
        if loads:
            found.append((count, self.recording.command.shape[1]))
        return found

    def servos_apart(self, values: Mapping[str, float]) -> Array:
        """Compute the servos' modelled minus reported displacements [m], shape (r, moving)."""
        count = self.reports_count
        expected = tendon_ends(self.recording, self.recording.report_times[count], values["lag"], values["backlash"])
        return np.asarray((expected - self.recording.reported[count])[:, self._moving])


def true_ends(reported: Array, values: Mapping[str, float]) -> Array:
    """Return the displacements of the tendons' ends [m] from reported or commanded ones, shape (..., n)."""
    zeros = np.array([values[f"zero_{i}"] for i in range(reported.shape[-1])])
    return np.asarray(values["spool"] * reported + values["zero"] + zeros)


MOTIONLESS = {"measured": ("delay", "lag", "backlash"), "command": ("delay",)}
"""Parameters that the rod's motion does not depend on, by drive."""
