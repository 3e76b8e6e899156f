"""The paper's figures, from a log. Import this module only to draw: it takes a second and needs the extra `plot`."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tendond.offline.logs.log import LogFile
from tendond.offline.logs.metrics import SETTLED, metrics, tracking
from tendond.offline.logs.published import Published
from tendond.offline.plots.style import OURS, PAPERS, REFERENCE, gravity_arrow, level, note, save, style

Array = NDArray[np.float64]

SHAPE_EVERY = 5
"""Cycles between two rod shapes that are drawn, as in the paper."""

MAX_SHAPES = 100
MIN_ITERATIONS = 100
"""Minimum number of iterations drawn, if there are so many: more after settling would only compress the rest."""

SIZE = (6.4, 4.0)  # [inch]
SHAPES_SIZE = (6.4, 4.6)


def draw(log: LogFile, folder: Path, suffix: str = "png", published: Published | None = None) -> list[Path]:
    """Draw the tracking part of a log into `folder`, which is made: PNG files (or SVG), the overview last.

    Raises:
        LogError: see `tracking`.
    """
    run = _PlottedRun(log, published)
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    with style():
        for name, panel in {**run.panels, "shapes": run.shapes}.items():
            figure = Figure(SHAPES_SIZE if name == "shapes" else SIZE, layout="constrained")
            panel(figure.subplots())
            paths.append(save(figure, folder / f"{name}.{suffix}"))
        paths.append(save(_overview(run, log), folder / f"overview.{suffix}"))
    return paths


def overview(log: LogFile, published: Published | None = None) -> Figure:
    """Draw the four panels in one figure; raises LogError, see `tracking`."""
    with style():
        return _overview(_PlottedRun(log, published), log)


def shapes_figure(log: LogFile) -> Figure:
    """Draw the rod's shapes; raises LogError, see `tracking`."""
    with style():
        figure = Figure(SHAPES_SIZE, layout="constrained")
        _PlottedRun(log).shapes(figure.subplots())
    return figure


def _overview(run: "_PlottedRun", log: LogFile) -> Figure:
    figure = Figure((2 * SIZE[0], 2 * SIZE[1]), layout="constrained")
    for axes, panel in zip(figure.subplots(2, 2).flat, run.panels.values(), strict=True):
        panel(axes)
    figure.suptitle(f"{log.name}: {run.law}", x=0.01, ha="left", fontsize=12)
    return figure


class _PlottedRun:
    """The tracking part of a log, in mm, and how to draw it."""

    def __init__(self, log: LogFile, published: Published | None = None) -> None:
        series = tracking(log)
        self.law = log.config.control.law.replace("_", " ")
        self.letter = "xyz"[series.axis]
        self._axis = series.axis
        self._ticks = series.ticks
        self._tip = 1000.0 * series.tip
        self._reference = 1000.0 * series.reference
        self._target = 1000.0 * np.array(series.target)
        self._displacement = 1000.0 * series.displacement[:, series.agonist]
        self._metrics = metrics(series)
        self._paper = published
        settling = self._metrics.settling_iterations
        self._shown = len(self._tip) if settling is None else min(len(self._tip), max(MIN_ITERATIONS, 3 * settling))
        self._gravity = np.array(log.config.rod.base_gravity)
        self._shapes = [(tick - int(self._ticks[0]), 1000.0 * points) for tick, points in log.shapes]

    @property
    def panels(self) -> dict[str, Callable[[Axes], None]]:
        """The paper's four, by the names of their files."""
        return {
            f"tip_{self.letter}": self.tip_bending,
            "tip_z": self.tip_z,
            "displacement": self.displacement,
            "error": self.error,
        }

    def tip_bending(self, axes: Axes) -> None:
        """x of the tip (or y), its reference, and the band round the target in which it has settled."""
        target = self._target[self._axis]
        values = self._tip[:, self._axis]
        axes.axhspan((1 - SETTLED) * target, (1 + SETTLED) * target, color=REFERENCE, alpha=0.12, lw=0)
        level(
            axes, target, f"target {target:.0f} mm{', as in the paper' if self._paper else ''}; band ±5 %", below=True
        )
        axes.plot(self._reference[: self._shown, self._axis], color=REFERENCE, lw=1.2, ls="--")
        self._line(axes, values, f"tip {self.letter} [mm]", f"{self.letter} of the tip")
        at = int(np.argmax(values / target))
        if self._metrics.overshoot_percent > 0.0 and at < self._shown:
            axes.plot(at, values[at], "o", color=OURS, ms=4)
            note(axes, (at, values[at]), f"overshoot {self._metrics.overshoot_percent:.1f} %", OURS, (6, 4))
        at = min(8, self._shown - 1)
        note(axes, (at, self._reference[at, self._axis]), "reference", REFERENCE, (8, -8))

    def tip_z(self, axes: Axes) -> None:
        """z of the tip: from the rod's length towards the target."""
        level(axes, self._target[2], f"target {self._target[2]:.1f} mm")
        self._line(axes, self._tip[:, 2], "tip z [mm]", "z of the tip")

    def displacement(self, axes: Axes) -> None:
        """Draw the commanded displacement of the agonist."""
        final = self._displacement[-1]
        if self._paper is not None and self._paper.final_displacement_mm is not None:
            value = self._paper.final_displacement_mm
            level(axes, value, f"paper {value:.0f} mm", PAPERS, below=True)
        self._line(axes, self._displacement, "displacement [mm]", f"Tendon displacement, {final:.1f} mm at the end")

    def error(self, axes: Axes) -> None:
        """Draw the distance of the tip from its reference."""
        distance = np.linalg.norm(self._reference - self._tip, axis=1)
        axes.set_ylim(0.0, 1.05 * float(distance.max()))
        self._line(axes, distance, "|reference - tip| [mm]", f"Position error, {distance[-1]:.2f} mm at the end")

    def shapes(self, axes: Axes) -> None:
        """Draw the rod in its bending plane, every few cycles, with gravity as far down as the plane allows."""
        every = max(SHAPE_EVERY, -(-self._shown // MAX_SHAPES))
        colours = ScalarMappable(Normalize(0, self._shown), "viridis")
        level_rod = abs(self._gravity[self._axis]) > abs(self._gravity[2])
        right, up = (2, self._axis) if level_rod else (self._axis, 2)
        # From the last one before tracking, which is the rod at rest.
        due = max((iteration for iteration, _ in self._shapes if iteration <= 0), default=0)
        for iteration, points in self._shapes:
            if due <= iteration < self._shown:
                colour = colours.cmap(max(0, iteration) / self._shown)
                axes.plot(points[:, right], points[:, up], color=colour, lw=1.2)
                due = iteration + every
        axes.plot(self._target[right], self._target[up], "x", color=PAPERS, ms=9, mew=2)
        note(axes, (self._target[right], self._target[up]), "target", PAPERS, (-6, -18) if level_rod else (8, -4))
        gravity_arrow(axes, self._gravity[[right, up]])
        axes.set(
            xlabel=f"{'xyz'[right]} [mm]",
            ylabel=f"{'xyz'[up]} [mm]",
            title=f"Rod every {every} iterations",
            aspect="equal",
        )
        axes.figure.colorbar(colours, ax=axes, label=self._iterations)

    def _line(self, axes: Axes, values: Array, label: str, title: str) -> None:
        axes.plot(values[: self._shown], color=OURS)
        axes.set(xlabel=self._iterations, ylabel=label, title=title, xlim=(0, max(1, self._shown - 1)))

    @property
    def _iterations(self) -> str:
        count = len(self._tip)
        return "iteration" if self._shown == count else f"iteration (the first {self._shown} of {count})"
