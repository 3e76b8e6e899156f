"""Panels of a run over time: the tip, its error, tensions, displacements, speeds. Import this module only to draw."""

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from tendond.offline.logs.log import LogFile
from tendond.offline.logs.metrics import SETTLED, Tracking, metrics
from tendond.offline.logs.published import Published
from tendond.offline.plots.appearance import appearance
from tendond.offline.plots.style import DARK, OURS, PAPERS, REFERENCE, legend_above, line_look, title

Array = NDArray[np.float64]

MIN_SHOWN = 100
"""Minimum number of iterations drawn, if there are so many: more after settling would only compress the rest."""

MIN_RANGE = 0.02
"""Smallest range of an axis of a position, as a fraction of the rod's length: below it there is only noise."""

INJECTED = "#8c1c13"


class Panels:
    """A run in mm, N and mm/s, and how to draw it.

    Args:
        log: the log. run: one of its runs. published: a paper's figures of it.
    """

    def __init__(self, log: LogFile, run: Tracking, published: Published | None = None) -> None:
        self.run = run
        self._paper = published
        self._scale = appearance().unit_of_time(log.config.loop.period)
        self._period = log.config.loop.period
        self._min_range = 1e3 * MIN_RANGE * log.config.rod.backbone_length
        self._metrics = metrics(run) if run.has_metrics else None
        self.goes_to_target = run.has_metrics and _goes_to_target(run)
        settling = self._metrics.settling_iterations if self._metrics else None
        cut = self.goes_to_target and not run.injections and settling is not None
        self.names_injections = True
        """The legends name the injections; in an overview that of the first panel is enough."""
        self.shown = min(len(run.tip), max(MIN_SHOWN, 3 * (settling or 0))) if cut else len(run.tip)

    @property
    def all(self) -> dict[str, Callable[[Axes], None]]:
        """The panels, by the names of their files."""
        return {
            "tip_x": lambda axes: self.component(axes, 0),
            "tip_y": lambda axes: self.component(axes, 1),
            "tip_z": lambda axes: self.component(axes, 2),
            "error": self.error,
            "tension": self.tensions,
            "displacement": self.displacements,
            "tip_speed": self.tip_speed,
            "tendon_speed": self.tendon_speeds,
        }

    def component(self, axes: Axes, index: int) -> None:
        """Draw a component of the tip, its reference and its target."""
        name, target = "xyz"[index], 1e3 * self.run.target[index]
        tip = 1e3 * self.run.tip[:, index]
        bends = self.goes_to_target and index == self.run.axis
        if bends:
            half = SETTLED * 1e3 * abs(self.run.step)
            band = (target - half, target + half)
            axes.axhspan(*band, color=REFERENCE, alpha=0.15, lw=0)
        if self.goes_to_target:
            whose = "paper's target" if self._paper and bends else "target"
            about = f" ± {half:.2g}" if bends else ""
            axes.axhline(target, color=REFERENCE, lw=0.8, label=f"{whose} {target:.0f}{about} mm")
        self._curve(axes, 1e3 * self.run.reference[:, index], color=DARK, ls=(0, (4, 2)), lw=0.7, label="reference")
        self._curve(axes, tip, color=OURS, label="tip")
        if bends:
            self._milestones(axes, tip)
        self._finish(axes, f"tip {name} [mm]", f"{name} of the tip", self._min_range)

    def _milestones(self, axes: Axes, tip: Array) -> None:
        """Mark overshoot and settling, both before the first injection."""
        assert self._metrics is not None
        calm = tip[: self.run.calm]
        at = int(np.argmax((calm / 1e3 - self.run.begin) / self.run.step))
        found = self._metrics
        size = appearance().points(5.0)
        if found.overshoot_percent > 0.05 and at < self.shown:
            label = f"overshoot {found.overshoot_percent:.1f} %"
            axes.plot(self._time[at], tip[at], "o", color=PAPERS, ms=size, label=label)
        if found.settling_iterations is not None and found.settling_iterations < self.shown:
            at = found.settling_iterations
            when = f"{at} iterations" if appearance().iterations else f"{self._time[at]:.2f} s"
            axes.plot(self._time[at], tip[at], "D", color=OURS, mfc="white", ms=size, label=f"settled, {when}")

    def error(self, axes: Axes) -> None:
        """Draw the distance of the tip from its reference."""
        distance = 1e3 * np.linalg.norm(self.run.reference - self.run.tip, axis=1)
        self._curve(axes, distance, color=OURS)
        axes.set_ylim(0.0, 1.05 * max(float(distance[: self.shown].max()), 1e-3))
        self._finish(axes, "|reference - tip| [mm]", f"Position error, {distance[-1]:.2f} mm at the end")

    def tensions(self, axes: Axes) -> None:
        """Draw the commanded tension of each tendon."""
        self._tendons(axes, self.run.tension)
        self._finish(axes, "tension [N]", "Commanded tensions")

    def displacements(self, axes: Axes) -> None:
        """Draw the commanded displacement of each tendon, and a paper's of the agonist at the end."""
        values = 1e3 * self.run.displacement
        self._tendons(axes, values)
        if self._paper is not None and self._paper.final_displacement_mm is not None:
            value = self._paper.final_displacement_mm
            axes.axhline(value, color=PAPERS, lw=1.0, ls=":", label=f"paper, {value:.0f} mm")
        self._finish(axes, "displacement [mm]", "Commanded displacements")

    def tip_speed(self, axes: Axes) -> None:
        """Draw the speed of the measured tip."""
        speed = 1e3 * np.linalg.norm(self._rate(self.run.tip), axis=1)
        self._curve(axes, speed, color=OURS)
        self._finish(axes, "speed [mm/s]", "Speed of the measured tip")

    def tendon_speeds(self, axes: Axes) -> None:
        """Draw the rate of each commanded displacement."""
        self._tendons(axes, 1e3 * self._rate(self.run.displacement))
        self._finish(axes, "speed [mm/s]", "Speeds of the tendons")

    def _rate(self, values: Array) -> Array:
        """Return the rate of change, shape of `values`; zero of a single sample."""
        if len(values) < 2:
            return np.zeros_like(values)
        return np.asarray(np.gradient(values, self._period * (self.run.ticks - self.run.ticks[0]), axis=0))

    def _tendons(self, axes: Axes, values: Array) -> None:
        for number, column in enumerate(values.T):
            self._curve(axes, column, label=f"tendon {number}", **line_look(number, length=self.shown))

    @property
    def _time(self) -> Array:
        return np.asarray(self._scale * (self.run.ticks - self.run.ticks[0]), dtype=float)

    def _curve(self, axes: Axes, values: Array, **look: Any) -> None:
        """Draw a curve, with a gap wherever cycles are not in the log."""
        time, values = self._time[: self.shown], values[: self.shown]
        gaps = np.flatnonzero(np.diff(self.run.ticks[: self.shown]) > 1) + 1
        axes.plot(np.insert(time, gaps, np.nan), np.insert(values, gaps, np.nan), **look)

    def _finish(self, axes: Axes, label: str, text: str, min_range: float = 0.0) -> None:
        """Mark the injections, name the axes and the curves."""
        self._mark_injections(axes)
        end = max(self._scale, float(self._time[self.shown - 1]))
        axes.set(xlabel=self.time_label, ylabel=label, xlim=(0.0, end))
        low, high = axes.get_ylim()
        if high - low < min_range:
            axes.set_ylim((low + high - min_range) / 2, (low + high + min_range) / 2)
        title(axes, text)
        legend_above(axes)

    def _mark_injections(self, axes: Axes) -> None:
        names = ", ".join(dict.fromkeys(one.what for one in self.run.injections))
        for number, one in enumerate(self.run.injections):
            first = self._time[one.start]
            label = f"injected: {names}" if number == 0 and self.names_injections else None
            axes.axvline(first, color=INJECTED, lw=0.9, ls=":", label=label)
            if one.end is not None:
                axes.axvspan(first, self._time[one.end], color=INJECTED, alpha=0.12, lw=0)

    @property
    def time_label(self) -> str:
        """Label of the axis of time, with what is shown of the run."""
        label = appearance().time_label
        if self.shown == len(self.run.tip):
            return label
        if appearance().iterations:
            return f"iteration (the first {self.shown} of {len(self.run.tip)})"
        return f"{label} (the first {self._time[self.shown - 1]:.1f} of {self._time[-1]:.1f} s)"


def _goes_to_target(run: Tracking) -> bool:
    """Return whether the reference goes straight to its target in the direction of bending, and stays there."""
    bend = run.reference[:, run.axis]
    travel = float(np.abs(np.diff(bend)).sum())
    return abs(bend[-1] - run.target[run.axis]) < 1e-3 and travel < 1.5 * abs(float(bend[-1] - bend[0])) + 1e-3
