"""What a recording's tip should have done if the parameters were such and such: the displacement-driven rod, offline.

Servos follow the commands with a first-order lag (or their own reports are believed), pull on elastic tendons, and the
tip is seen a delay later. Where the torque is off the tendons are slack. The rod starts at rest, as the arm did.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.signal import lfilter

from tendond.daemon.errors import DaemonError
from tendond.daemon.identify.data import Recording
from tendond.daemon.identify.parameters import rod_parameters
from tendond.model.course import course
from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.rod import Rod

Array = NDArray[np.float64]
Drive = Literal["measured", "command"]

TIME_STEP = 0.005
"""[s] At most. The controller's 10 ms shift the rod's first frequency by a percent, which would be found as density.

The grid lies half a step off the commands: a jump within an implicit step counts as one in its middle.
"""

ALPHA = -0.45
"""Of BDF-alpha: near the trapezoidal rule, whose own damping would be taken off the rod's."""

LET_GO = -1.0
"""[m] Displacement of a tendon whose servo has no torque: slack in every shape."""

SETTLING = 0.3
"""[s] After the torque comes on, for which servos are on their way from where they had been."""


class SimulationError(DaemonError):
    """Parameters that move the rod where it has no solution."""


@dataclass(frozen=True)
class Motion:
    """The rod through a recording.

    Attributes:
        step: [s]; tips: at its multiples from zero on [m], shape (steps + 1, 3).
        tensions: after each step [N], shape (steps, n).
    """

    step: float
    tips: Array
    tensions: Array


class Simulation:
    """A recording that can be simulated with any parameters; free of state, for use by several threads.

    Args:
        recording: of the rig.
        drive: what the tendons' ends are taken from.
        time_step: at most [s].
    """

    def __init__(self, recording: Recording, drive: Drive, time_step: float = TIME_STEP) -> None:
        self.recording = recording
        self.drive = drive
        period = recording.period
        self.step = period / math.ceil(period / time_step - 1e-9)
        last = max(recording.duration, float(recording.pose_times[-1]))
        self._ends_at = self.step * (np.arange(math.ceil(last / self.step) + 2) + 0.5)
        now = np.searchsorted(recording.times, self._ends_at, side="right") - 1
        self._command = recording.command[now]
        self._armed = recording.armed[now]
        edges = np.flatnonzero(np.diff(self._armed.astype(int)))
        self._stretches = list(zip(np.r_[0, edges + 1], np.r_[edges + 1, len(now)], strict=True))
        since = np.full(len(now), -math.inf)
        for first, end in self._stretches:
            if self._armed[first]:
                since[first:end] = self._ends_at[first] - 0.5 * self.step
        rows = np.clip(np.searchsorted(self._ends_at, recording.report_times - 1e-9), 0, len(now) - 1)
        self.reports_count = self._armed[rows] & (recording.report_times - since[rows] > SETTLING)
        self.reports_count &= recording.report_times > 0.0

    def shaft(self, lag: float) -> Array:
        """Displacement at which the servos report to be, by the commands and a lag [s]: [m], shape (steps, n)."""
        left = math.exp(-self.step / lag) if lag > 0.0 else 0.0
        shaft = np.empty_like(self._command)
        for first, end in self._stretches:
            goal = self._command[first:end]
            shaft[first:end] = lfilter([1.0 - left], [1.0, -left], goal, axis=0, zi=left * goal[:1])[0]
        return shaft

    def _reported(self) -> Array:
        """Displacement of the tendons' ends by the servos' reports [m], shape (steps, n), where they are armed."""
        at, recording = self._ends_at, self.recording
        ends = np.empty_like(self._command)
        for first, end in self._stretches:
            times = recording.report_times
            rows = (times >= at[first] - self.step) & (times <= at[end - 1] + self.step)
            if np.count_nonzero(rows) < 2:
                ends[first:end] = self._command[first:end]
                continue
            times = times[rows]
            inside = np.clip(at[first:end], times[0], times[-1])
            ends[first:end] = PchipInterpolator(times, recording.reported[rows])(inside)
        return ends

    def motion(self, values: Mapping[str, float]) -> Motion:
        """The rod's course.

        Args:
            values: of all parameters, by name.

        Raises:
            SimulationError: no solution, with the time at which.
        """
        recording = self.recording
        try:
            rod = Rod(rod_parameters(recording.config, values), time_step=self.step, alpha=ALPHA)
        except ParameterError as error:
            raise SimulationError(f"{recording.path}: {error}") from error
        if self.drive == "measured":
            ends = self._reported()
        else:
            ends = self.shaft(values["lag"])
        ends = values["spool"] * ends + values["zero"]
        ends[~self._armed] = LET_GO
        start = ends[0] if self._armed[0] else np.full(ends.shape[1], LET_GO)
        loads = np.tile(rod.loads(start, tip_force=recording.force), (len(ends), 1))
        loads[:, : ends.shape[1]] = ends
        try:
            rest = rod.solve_static(displacements=start, tip_force=recording.force)
        except ConvergenceError as error:
            raise SimulationError(f"{recording.path}: the rod has no rest to start from: {error}") from error
        found = course(rod, rest, loads)
        if found.solved < len(loads):
            at = self._ends_at[found.solved]
            shown = ", ".join(f"{name} {value:.4g}" for name, value in values.items())
            raise SimulationError(f"{recording.path}: the rod has no solution at {at:.2f} s with {shown}")
        return Motion(self.step, np.vstack([rod.tip(rest).position, found.tips]), found.tensions)

    def seen(self, motion: Motion, delay: float) -> Array:
        """The poses that would have arrived [m], shape (m, 3): the tip of `delay` [s] before, by cubic interpolation."""
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

    def residuals(self, values: Mapping[str, float], motion: Motion, load_noise: float | None) -> list[Array]:
        """Model minus measurement, a row for each sample, in metres of the tip.

        Args:
            values: of all parameters, by name.
            motion: with these values, but for those that `motion` does not depend on.
            load_noise: of the reported tensions [N]; none: they are not used.

        Returns:
            Of the poses, shape (m, 3); where `drive` is 'measured', of the servos against their commands, shape (r, n);
            where loads are used, of the tensions, in units of their noise times the poses' noise, shape (r, n).
        """
        recording = self.recording
        found = [self.seen(motion, values["delay"]) - recording.position]
        rows = np.clip(np.searchsorted(self._ends_at, recording.report_times - 1e-9), 0, len(self._ends_at) - 1)
        rows, count = rows[self.reports_count], self.reports_count
        if self.drive == "measured":
            found.append(self.shaft(values["lag"])[rows] - recording.reported[count])
        if load_noise is not None:
            scale = max(recording.noise, 1e-5) / load_noise
            found.append(scale * (motion.tensions[rows] - recording.pulled[count]))
        return found


MOTIONLESS = {"measured": ("delay", "lag"), "command": ("delay",)}
"""Parameters that a rod's course does not depend on, by drive: their derivatives cost no simulation."""
