"""What a recording's tip should have done if the parameters were such and such: the displacement-driven rod, offline.

Servos follow the commands with a first-order lag (or their own reports are believed), pull on elastic tendons, and the
tip is seen a delay later. Where the torque is off the tendons are slack. The rod starts at rest, as the arm did. A
known weight is a rigid body on the tip, with the inertia of a brass ball.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.optimize import minimize_scalar

from tendond.daemon.errors import DaemonError
from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.rod.rod import Rod
from tendond.model.rod.tip_body import ball_inertia
from tendond.model.rod.trajectory import simulate_trajectory
from tendond.offline.identification.data import Recording
from tendond.offline.identification.parameters import rod_parameters

Array = NDArray[np.float64]
Drive = Literal["measured", "command"]

TIME_STEP = 0.005
"""[s] At most. The controller's 10 ms shift the rod's first frequency by a percent, which would be found as density.

The grid lies half a step off the commands: a jump within an implicit step counts as one in its middle.
"""

ALPHA = -0.45
"""Of BDF-alpha: near the trapezoidal rule, whose own damping would be taken off the rod's."""

NO_LAG = 1e-6
"""[s] That stands for none."""

LET_GO = -1.0
"""[m] Displacement of a tendon whose servo has no torque: slack in every shape."""

TRAVEL = 0.002
"""[m] From which on a servo moves: where one that hardly does lies within its backlash, nobody knows."""

PULLING = 3.0
"""Of the noise of the servos' tensions, from which on they count: a slack tendon's cannot fall below zero."""

SETTLING = 0.3
"""[s] After the torque comes on, while the servos move from their previous positions."""


class SimulationError(DaemonError):
    """Parameters that move the rod where it has no solution."""


@dataclass(frozen=True)
class TipMotion:
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
        self._ends_at: Array = np.asarray(
            self.step * (np.arange(math.ceil(last / self.step) + 2) + 0.5), dtype=np.float64
        )
        now = np.searchsorted(recording.times, self._ends_at, side="right") - 1
        self._command = recording.command[now]
        self._armed = recording.armed[now]
        edges = np.flatnonzero(np.diff(self._armed.astype(int)))
        self._stretches = list(zip(np.r_[0, edges + 1], np.r_[edges + 1, len(now)], strict=True))
        self.reports_count = _settled(recording)
        reported = recording.reported[self.reports_count]
        travel = np.ptp(reported, axis=0) if len(reported) else np.zeros(recording.command.shape[1])
        self._moving = np.flatnonzero(travel > TRAVEL)
        self._ends = self._reported() if drive == "measured" else np.zeros_like(self._command)

    def shaft(self, times: Array, lag: float) -> Array:
        """Where servos with a first-order lag [s] are at these times by the commands alone [m], shape (len(times), n).

        Exact between commands. A servo whose torque comes on starts at its first command.
        """
        recording = self.recording
        at, command = recording.times, recording.command
        lag = max(lag, NO_LAG)
        left = np.exp(-np.diff(at) / lag)
        reached = command.copy()  # when each command is given
        for k in range(1, len(at)):
            if recording.armed[k - 1]:
                reached[k] = command[k - 1] + left[k - 1] * (reached[k - 1] - command[k - 1])
        now = np.clip(np.searchsorted(at, times + 1e-9, side="right") - 1, 0, len(at) - 1)
        fading = np.exp(-np.maximum(times - at[now], 0.0) / lag)[:, None]
        return np.asarray(command[now] + fading * (reached[now] - command[now]))

    def servo(self, times: Array, lag: float, backlash: float) -> Array:
        """As `shaft`, of what the servos move when their gears have a backlash [m]."""
        recording = self.recording
        knots = np.union1d(recording.times, times)  # between two of them a shaft turns in one direction only
        shaft = self.shaft(knots, lag)
        if backlash > 0.0:
            now = np.searchsorted(recording.times, knots + 1e-9, side="right") - 1
            armed = recording.armed[np.maximum(now, 0)]
            play, end = 0.5 * backlash, shaft[0]
            low, high = shaft - play, shaft + play
            for k in range(1, len(knots)):
                end = np.minimum(np.maximum(end, low[k]), high[k]) if armed[k - 1] else shaft[k]
                shaft[k] = end
        return np.asarray(shaft[np.searchsorted(knots, times)])

    def _reported(self) -> Array:
        """Displacement of the tendons' ends by the servos' reports [m], shape (steps, n), where they are armed.

        Between two reports either as a smooth curve goes, or as the commands and a lag let expect: whichever is better
        at every second report, from the others.
        """
        recording, count = self.recording, self.reports_count

        def off(lag: float) -> float:
            apart = self.shaft(recording.report_times[count], lag) - recording.reported[count]
            return float(np.sum(apart**2))

        lag = float(minimize_scalar(off, bounds=(NO_LAG, 0.3), method="bounded").x)
        times = recording.report_times
        expected, at = self.shaft(times, lag), self.shaft(self._ends_at, lag)
        missed = [float(np.sum((self._filled(y, 2, times) - y)[count] ** 2))
                  for y in (recording.reported - expected, recording.reported)]  # fmt: skip
        if missed[0] < missed[1]:
            return np.asarray(at + self._filled(recording.reported - expected, 1, self._ends_at))
        return self._filled(recording.reported, 1, self._ends_at)

    def _filled(self, reported: Array, every: int, where: Array) -> Array:
        """Reports' values [m] at other times, shape (len(where), n), from each `every`th; each stretch for itself."""
        filled = np.zeros((len(where), reported.shape[1]))
        times = self.recording.report_times
        for first, end in self._stretches:
            start, stop = self._ends_at[first] - self.step, self._ends_at[end - 1] + self.step
            rows = np.flatnonzero((times >= start) & (times <= stop))[::every]
            inside = (where >= start) & (where <= stop)
            if len(rows) >= 2:
                points = np.clip(where[inside], times[rows[0]], times[rows[-1]])
                filled[inside] = PchipInterpolator(times[rows], reported[rows])(points)
        return filled

    def motion(self, values: Mapping[str, float]) -> TipMotion:
        """The rod's motion.

        Args:
            values: of all parameters, by name.

        Raises:
            SimulationError: no solution, with the time at which.
        """
        recording = self.recording
        try:
            rod = Rod(rod_parameters(recording.config, values), time_step=self.step, alpha=ALPHA)
            rod.load_tip(recording.weight, ball_inertia(recording.weight))
        except ParameterError as error:
            raise SimulationError(f"{recording.path}: {error}") from error
        measured = self.drive == "measured"
        ends = self._ends if measured else self.servo(self._ends_at, values["lag"], values["backlash"])
        ends = values["spool"] * ends + values["zero"]
        ends[~self._armed] = LET_GO
        start = ends[0] if self._armed[0] else np.full(ends.shape[1], LET_GO)
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

    def seen(self, motion: TipMotion, delay: float) -> Array:
        """The poses that would have arrived [m], shape (m, 3): the tip `delay` [s] before, by cubic interpolation."""
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
        """Model minus measurement, a row for each sample, in metres of the tip.

        Args:
            values: of all parameters, by name.
            motion: with these values, but for those that `motion` does not depend on.
            load_noise: of the reported tensions [N]; none: they are not used.

        Returns:
            Of the poses, shape (m, 3); where `drive` is 'measured', of the servos that move, against their commands,
            shape (r, those);
            where loads are used, of the tensions, in units of their noise times the poses' noise, shape (r, n).
        """
        recording = self.recording
        found = [self.seen(motion, values["delay"]) - recording.position]
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
        """Of the blocks of `residuals`, with or without the tensions."""
        count = int(np.count_nonzero(self.reports_count))
        found = [(len(self.recording.pose_times), 3)]
        if self.drive == "measured":
            found.append((count, len(self._moving)))
        if loads:
            found.append((count, self.recording.command.shape[1]))
        return found

    def servos_apart(self, values: Mapping[str, float]) -> Array:
        """Servos by their commands minus their reports [m], shape (r, those that move)."""
        count = self.reports_count
        expected = self.servo(self.recording.report_times[count], values["lag"], values["backlash"])
        return np.asarray((expected - self.recording.reported[count])[:, self._moving])


def _settled(recording: Recording) -> NDArray[np.bool_]:
    """Reports of servos whose torque has been on for a while, shape (r,)."""
    before = np.searchsorted(recording.times, recording.report_times - 1e-9) - 1
    on = np.flatnonzero(recording.armed & ~np.r_[False, recording.armed[:-1]])
    if not on.size:
        return np.zeros(len(before), dtype=bool)
    last = np.searchsorted(on, before, side="right") - 1
    since = recording.report_times - recording.times[on[np.maximum(last, 0)]]
    return np.asarray((before >= 0) & (last >= 0) & recording.armed[before] & (since > SETTLING + 1e-9))


MOTIONLESS = {"measured": ("delay", "lag", "backlash"), "command": ("delay",)}
"""Parameters that a rod's motion does not depend on, by drive: their derivatives cost no simulation."""
