"""Pictures of a run as it moves: rod, tendons, target, forces, traces. Import this module only to draw."""

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from tendond.offline.logs.log import LogFile
from tendond.offline.logs.metrics import Tracking
from tendond.offline.logs.paths import TipPath
from tendond.offline.movies.motion import arrow, between, held_force
from tendond.offline.plots.spatial import box_limits, gravity_in_space
from tendond.offline.plots.spline import smooth
from tendond.offline.plots.style import DARK, LINES, OURS, PAPERS, REFERENCE, gravity_arrow, line_look, style

Array = NDArray[np.float64]

ESTIMATE, TRUTH, FAINT = "#b2182b", "#6d2c7f", "#d4d8dd"
COLOURS = (*(colour for colour, _, _ in LINES), OURS, REFERENCE, PAPERS, DARK, ESTIMATE, TRUTH, FAINT, "#000000")
"""Colours of all that is drawn, for files that can have only a few."""

SIZE = (9.0, 5.04)
"""Size of the figure [inch]; a picture has more or fewer pixels by its resolution."""

FORCE_LENGTH = 0.22
"""Length of the arrow of the largest force, as a fraction of the rod's length."""

FORCE_FLOOR = 0.005
"""Smallest force that has the longest arrow, as a fraction of the largest tension: below it there is rounding."""

MIN_FORCE = 0.02
"""Smallest force that is drawn, as a fraction of the largest."""

HEAD = 0.25
"""Length of an arrow's head, as a fraction of the longest arrow."""

FLAT_PLACE, SPACE_PLACE = (0.075, 0.11, 0.45, 0.69), (0.0, 0.02, 0.53, 0.8)
TRACE_PLACES = ((0.635, 0.69, 0.345, 0.22), (0.635, 0.41, 0.345, 0.22), (0.635, 0.11, 0.345, 0.22))
"""Places of the scene, in a plane and in space, and of the traces, in fractions of the picture: left, bottom, width,
height."""

TICKS = 4

FLAT_MM = 5.0
"""Largest distance of the rod from a plane in which a run is drawn [mm]."""


class Scene:
    """Pictures of a run at any of its times.

    Args:
        log: the log. run: one of its runs.
        width: of a picture [pixels]. span: first and last time since the run's start that will be shown [s].
    """

    def __init__(self, log: LogFile, run: Tracking, width: int, span: tuple[float, float]) -> None:
        self._run = run
        self._path = TipPath.of(log, (int(run.ticks[0]), int(run.ticks[-1])))
        self._period = log.config.loop.period
        self._start = int(run.ticks[0]) * self._period
        first = int(np.searchsorted([record.tick for record in log.records], run.ticks[0]))
        records = log.records[first : first + len(run.ticks)]
        self._estimate = np.array([record.observer.force for record in records])
        self._truth = held_force(log, run.ticks) if log.truth else None
        sizes = [float(np.linalg.norm(one, axis=1).max()) for one in (self._estimate, self._truth) if one is not None]
        self._largest = max(*sizes, FORCE_FLOOR * float(run.tension.max()), 1e-9)
        self._reach = FORCE_LENGTH * 1e3 * log.config.rod.backbone_length
        self._gravity = np.array(log.config.rod.base_gravity)
        self._span = span
        across = self._across()
        self._kept = [0, 1, 2] if across is None else self._plane(across)
        with style():
            self._draw_still(width)

    def _across(self) -> int | None:
        """Return the axis along which nothing happens; none of a run in space."""
        extents = 1e3 * np.abs(self._path.points).max(axis=0)
        return next((axis for axis in (1, 0) if extents[axis] < FLAT_MM), None)

    def _plane(self, across: int) -> list[int]:
        bends = 1 - across
        level = abs(self._gravity[bends]) > abs(self._gravity[2])
        return [2, bends] if level else [bends, 2]

    def _draw_still(self, width: int) -> None:
        """Draw all that does not move, and make what does."""
        self._figure = Figure(SIZE, dpi=width / SIZE[0])
        canvas: Any = FigureCanvasAgg  # which has no types
        self._canvas = canvas(self._figure)
        flat = len(self._kept) == 2
        place = FLAT_PLACE if flat else SPACE_PLACE
        self._space: Any = self._figure.add_axes(place, projection=None if flat else "3d")
        self._traces = [self._figure.add_axes(trace) for trace in TRACE_PLACES]
        self._moving: list[tuple[Any, Artist]] = []
        self._still_scene()
        self._tip, self._rod = self._scene_artists()
        text = self._figure.text(0.02, 0.965, "", fontsize=11, va="top")
        self._time_text = self._add(self._figure, text)
        self._lines = self._still_traces()
        self._cursors = [self._add(axes, axes.axvline(0.0, color=DARK, lw=0.8)) for axes in self._traces]
        self._canvas.draw()
        self._background = self._canvas.copy_from_bbox(self._figure.bbox)

    def _add(self, axes: Any, artist: Any) -> Any:
        artist.set_animated(True)
        self._moving.append((axes, artist))
        return artist

    def _line(self, **look: Any) -> Any:
        """Make a line in the scene that will move."""
        return self._add(self._space, self._space.plot(*([[]] * len(self._kept)), **look)[0])

    def _still_scene(self) -> None:
        space, kept = self._space, self._kept
        low, high = self._limits()
        space.plot(*(1e3 * self._path.reference[:, kept]).T, color=REFERENCE, lw=3.0, alpha=0.5, label="reference")
        if self._path.target is not None:
            target = 1e3 * np.array([self._path.target])[:, kept]
            space.plot(*target.T, "x", color=PAPERS, ms=9, mew=2, label="target")
        for letter, axis in zip("xyz", kept, strict=False):
            space.set(**{f"{letter}lim": (low[axis], high[axis]), f"{letter}label": f"{'xyz'[axis]} [mm]"})
            getattr(space, f"{letter}axis").set_major_locator(MaxNLocator(TICKS))
        if len(kept) == 2:
            self._fill(low[kept], high[kept])
            drawn = np.vstack([one.points for one in self._path.shapes] or [self._path.points])
            gravity_arrow(space, self._gravity[kept], 1e3 * drawn[:, kept])
        else:
            space.set_box_aspect(high - low, zoom=0.95)
            elevation, azimuth = self._path.view
            space.view_init(elev=elevation, azim=azimuth)
            gravity_in_space(space, self._gravity, low, high - low)

    def _limits(self) -> tuple[Array, Array]:
        """Return the corners of all that is drawn at any time, the forces' arrows too [mm]."""
        low, high = box_limits(self._path)
        forces = [self._estimate, *([] if self._truth is None else [self._truth])]
        ends = np.vstack([1e3 * self._run.tip + self._reach * force / self._largest for force in forces])
        return np.minimum(low, ends.min(axis=0)), np.maximum(high, ends.max(axis=0))

    def _fill(self, low: Array, high: Array) -> None:
        """Set the limits of a plane so that it has one scale, and fills its place."""
        width, height = np.array(self._figure.get_size_inches()) * FLAT_PLACE[2:]
        scale = max((high[0] - low[0]) / width, (high[1] - low[1]) / height)
        half, middle = 0.5 * scale * np.array([width, height]), 0.5 * (low + high)
        self._space.set(xlim=middle[0] + half[0] * np.array([-1, 1]), ylim=middle[1] + half[1] * np.array([-1, 1]))

    def _scene_artists(self) -> tuple[Any, Any]:
        """Make what moves in the scene, and the legend: tip and rod."""
        count = len(self._path.shapes[0].tendons) if self._path.shapes else 0
        self._tendons = [self._line(color="#9a9a9a", lw=0.8) for _ in range(count)]
        tip = self._line(color=OURS, lw=1.2, label="tip")
        rod = self._line(color="black", lw=3.0, label="rod")
        self._arrows = {"estimate": self._line(color=ESTIMATE, lw=2.0, label="force, estimate")}
        if self._truth is not None:
            self._arrows["truth"] = self._line(color=TRUTH, lw=1.5, ls=(0, (2, 1)), label="force, true")
        handles, labels = self._space.get_legend_handles_labels()
        self._figure.legend(
            handles, labels, loc="upper left", bbox_to_anchor=(0.01, 0.92), ncols=3, frameon=False, fontsize=9
        )
        return tip, rod

    def _still_traces(self) -> list[tuple[Any, Array]]:
        """Draw the traces faintly, and make the lines that follow the time."""
        run, time = self._run, self._run.time
        position, error, tension = self._traces
        lines: list[tuple[Any, Array]] = []

        def trace(axes: Any, values: Array, label: str, number: int) -> None:
            look = line_look(number, length=len(values), plain=True)
            axes.plot(time, values, color=FAINT, lw=1.2)
            lines.append((self._add(axes, axes.plot([], [], lw=1.5, label=label, **look)[0]), values))

        for axis, letter in enumerate("xyz"):
            trace(position, 1e3 * run.tip[:, axis], f"tip {letter}", axis)
        trace(error, 1e3 * np.linalg.norm(run.reference - run.tip, axis=1), "", 0)
        for number, column in enumerate(run.tension.T):
            trace(tension, column, f"tendon {number}", number)
        labels = ("position [mm]", "error [mm]", "tension [N]")
        for axes, label in zip(self._traces, labels, strict=True):
            axes.set(ylabel=label, xlim=self._span)
            axes.tick_params(labelbottom=axes is tension)
            _, names = axes.get_legend_handles_labels()
            if names:
                axes.legend(
                    loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, frameon=False, fontsize=8,
                    borderaxespad=0.1, handlelength=1.6, columnspacing=0.9, handletextpad=0.4,
                )  # fmt: skip
        tension.set_xlabel("time [s]")
        return lines

    def picture(self, time: float) -> NDArray[np.uint8]:
        """Draw the run at a time since its start [s]: red, green, blue, shape (height, width, 3)."""
        at = max(0, int(np.searchsorted(self._run.time, time + 1e-9, side="right")) - 1)
        self._canvas.restore_region(self._background)
        self._move_rod(time)
        self._put(self._tip, 1e3 * self._run.tip[: at + 1])
        tip = 1e3 * self._run.tip[at]
        self._point(self._arrows["estimate"], tip, self._estimate[at])
        if self._truth is not None:
            self._point(self._arrows["truth"], tip, self._truth[at])
        for line, values in self._lines:
            line.set_data(self._run.time[: at + 1], values[: at + 1])
        for cursor in self._cursors:
            cursor.set_xdata([time, time])
        acting = [one.what for one in self._run.injections if one.start <= at and (one.end is None or at < one.end)]
        force = float(np.linalg.norm(self._estimate[at]))
        more = f"   injected: {', '.join(acting)}" if acting else ""
        self._time_text.set_text(f"{time:.2f} s   estimated force {force:.2f} N{more}")
        for axes, artist in self._moving:
            axes.draw_artist(artist)
        return np.asarray(self._canvas.buffer_rgba())[:, :, :3].copy()

    def _move_rod(self, time: float) -> None:
        """Put rod and tendons between the recorded shapes before and after."""
        shapes = self._path.shapes
        if not shapes:
            return
        times = np.array([shape.time for shape in shapes]) - self._start + self._period  # after the cycle's step
        after = min(int(np.searchsorted(times, time)), len(shapes) - 1)
        before = max(after - 1, 0)
        gap = times[after] - times[before]
        part = float(np.clip((time - times[before]) / gap, 0.0, 1.0)) if gap > 0.0 else 1.0
        self._put(self._rod, 1e3 * between(shapes[before].points, shapes[after].points, part))
        for line, one, other in zip(self._tendons, shapes[before].tendons, shapes[after].tendons, strict=False):
            self._put(line, 1e3 * smooth(between(one, other, part)))

    def _put(self, line: Any, points: Array) -> None:
        if len(self._kept) == 2:
            line.set_data(*points[:, self._kept].T)
        else:
            line.set_data_3d(*points.T)

    def _point(self, line: Line2D, place: Array, force: Array) -> None:
        """Draw a force as an arrow that begins at a place [mm]."""
        size = float(np.linalg.norm(force))
        if size < MIN_FORCE * self._largest:
            self._put(line, np.full((1, 3), np.nan))
            return
        in_plane = len(self._kept) == 2 and 1 not in self._kept
        self._put(line, arrow(place, self._reach * force / self._largest, HEAD * self._reach, across=int(in_plane)))
