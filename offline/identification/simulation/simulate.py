"""Simulation of a recording with given parameters: the displacement-driven rod, offline.

Servos follow the commands with a first-order lag (or their own reports are used) and pull on elastic tendons; poses of
the tip arrive a delay later. Where the torque is off the tendons are slack. The rod starts at rest, as the arm did. A
known weight is a rigid body on the tip, with the inertia of a brass ball.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.errors import DaemonError
from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.rod.rod import Rod
from tendond.model.rod.tip_body import ball_inertia
from tendond.model.rod.trajectory import simulate_trajectory
from tendond.offline.identification.parameters import rod_parameters
from tendond.offline.identification.recordings.recording import Recording
from tendond.offline.identification.simulation.servos import reported_ends, settled_reports, tendon_ends

Array = NDArray[np.float64]


Drive = Literal["measured", "command"]


TIME_STEP = 0.005
"""Maximum time step [s]. The controller's 10 ms shift the rod's first frequency by a percent, an error of the density.

The grid lies half a step off the commands: a jump within an implicit step counts as one in its middle.
"""


ALPHA = -0.45
"""Alpha of BDF-alpha: near the trapezoidal rule, since numerical damping would be subtracted from the rod's."""


RELEASED = -1.0
"""Displacement of a tendon whose servo has no torque [m]: slack in every shape."""


TRAVEL = 0.002
"""Travel [m] above which a servo's reports are used: the position of one that hardly moves is lost in its backlash."""


PULLING = 3.0
"""Tension, in units of its noise, above which it is used: that of a slack tendon cannot fall below zero."""


class SimulationError(DaemonError):
    """Error of parameters with which the rod has no solution."""


@dataclass(frozen=True)
class TipMotion:
    """Motion of the rod during a recording.

    Attributes:
        step: time step [s]. tips: positions at its multiples from zero on [m], shape (steps + 1, 3).
        tensions: tendon tensions after each step [N], shape (steps, n).
    """

    step: float
    tips: Array
    tensions: Array


class Simulation:
    """A recording that can be simulated with any parameters; stateless, for use by several threads.

    Args:
        recording: the recording.
        drive: source of the tendons' ends.
        time_step: maximum time step [s].
    """

    def __init__(self, recording: Recording, drive: Drive, time_step: float = TIME_STEP) -> None:
        self.recording = recording
        self.drive = drive
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

    def motion(self, values: Mapping[str, float]) -> TipMotion:
        """Simulate the rod's motion.

        Args:
            values: values of all parameters, by name.

        Raises:
            SimulationError: no solution; with the time.
        """
        recording = self.recording
        try:
            rod = Rod(rod_parameters(recording.config, values), time_step=self.step, alpha=ALPHA)
            rod.load_tip(recording.weight, ball_inertia(recording.weight))
        except ParameterError as error:
            raise SimulationError(f"{recording.path}: {error}") from error
        measured = self.drive == "measured"
        ends = self._ends if measured else tendon_ends(recording, self._ends_at, values["lag"], values["backlash"])
        ends = values["spool"] * ends + values["zero"]
        ends[~self._armed] = RELEASED
        start = ends[0] if self._armed[0] else np.full(ends.shape[1], RELEASED)
        loads = np.tile(rod.loads(start), (len(ends), 1))
        loads[:, : ends.shape[1]] = ends
        try:
            rest = rod.solve_static(displacements=start)
        except ConvergenceError as error:
            raise SimulationError(f"{recording.path}: the rod has no rest to start from: {error}") from error
        found = simulate_trajectory(rod, rest, loads)
        if found.solved < len(loads):
            at = self._ends_at[found.solved]
            shown = ", ".join(f"{name} {value:.4g}" for name, value in values.items())
            raise SimulationError(f"{recording.path}: the rod has no solution at {at:.2f} s with {shown}")
        return TipMotion(self.step, np.vstack([rod.tip(rest).position, found.tips]), found.tensions)

    def predicted_poses(self, motion: TipMotion, delay: float) -> Array:
        """Predict the recording's poses [m], shape (m, 3): the tip `delay` [s] before, by cubic interpolation."""
        at = np.clip((self.recording.pose_times - delay) / motion.step + 0.5, 0.0, len(motion.tips) - 1.001)
        whole = at.astype(np.intp)
        t = (at - whole)[:, None]
        tips = motion.tips
        before, after = tips[np.maximum(whole - 1, 0)], tips[np.minimum(whole + 2, len(tips) - 1)]
        one, two = tips[whole], tips[whole + 1]
        return np.asarray(
            0.5 * (2.0 * one + t * (two - before)
            + t**2 * (2.0 * before - 5.0 * one + 4.0 * two - after)
            + t**3 * (3.0 * (one - two) + after - before))
        )  # fmt: skip

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
            rows = np.searchsorted(self._ends_at, recording.report_times[count] - 1e-9)
            scale = max(recording.noise, 1e-5) / load_noise
            tensions = motion.tensions[np.minimum(rows, len(motion.tensions) - 1)]
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


MOTIONLESS = {"measured": ("delay", "lag", "backlash"), "command": ("delay",)}
"""Parameters that the rod's motion does not depend on, by drive: their derivatives need no simulation."""
