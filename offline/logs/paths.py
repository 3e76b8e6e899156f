"""A run in space: paths of tip, reference and rod, for all views in three dimensions."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tendond.offline.logs.log import LogFile
from tendond.schemas.base import Vector3
from tendond.schemas.messages import ACTIVE, Mode

Array = NDArray[np.float64]

RUNNING = (Mode.PRETENSION, Mode.TRACKING)
"""Modes of a run."""

FLAT = 0.02
"""Fraction of a path's size up to which its thickness counts as flat."""

TILT_DEG, TURN_DEG = 12.0, 18.0
"""Angles between the view and the normal of a plane, so that its depth is visible."""


@dataclass(frozen=True)
class RodShape:
    """The rod in one cycle.

    Attributes:
        tick: the cycle's tick. time: nominal time since the first cycle of the run [s].
        points: points of the backbone, base to tip [m], shape (points, 3).
        tendons: beside it [m], shapes (k, 3).
    """

    tick: int
    time: float
    points: Array
    tendons: Sequence[Array]


@dataclass(frozen=True)
class TipPath:
    """Path of the tip from the first cycle that pulls to the last that tracks; over all cycles, where none tracks.

    Between two runs, and in a gap of the log, there is no path.

    Attributes:
        time: times of the cycles [s], shape (k,).
        tip: measured [m], NaN before the first pose, in the last cycle before a gap, and while nothing pulls, where
            something tracks; shape (k, 3).
        reference: reference of the tip while it tracks, else NaN [m], shape (k, 3).
        target: end of the reference; none where nothing tracks [m].
        shapes: shapes of the rod in that time, and the one at its beginning.
    """

    time: Array
    tip: Array
    reference: Array
    target: Vector3 | None
    shapes: Sequence[RodShape]

    @staticmethod
    def of(log: LogFile, ticks: tuple[int, int] | None = None) -> "TipPath":
        """Extract the path of a log, or of one run of it.

        Args:
            log: the log.
            ticks: first and last tick of the run; its path begins with the pretension. The probe before that pulls at
                each tendon, which would be spikes of the path.
        """
        low, high = ticks or (0, log.records[-1].tick)
        tracks = [i for i, one in enumerate(log.records) if one.mode is Mode.TRACKING and low <= one.tick <= high]
        if tracks and ticks:
            pulls = range(tracks[0], -1, -1)
            first = next((i + 1 for i in pulls if log.records[i].mode not in RUNNING), 0)
        else:
            first = next((i for i, record in enumerate(log.records) if record.mode in ACTIVE), 0) if tracks else 0
        part = log.records[first : tracks[-1] + 1] if tracks else log.records
        drawn = [record.mode in ACTIVE or not tracks for record in part]
        for i, (record, after) in enumerate(pairwise(part)):
            drawn[i] = drawn[i] and after.tick == record.tick + 1
        nowhere = (np.nan,) * 3
        period = log.config.loop.period
        shapes = [
            RodShape(tick, tick * period, points, tendons)
            for (tick, points), tendons in zip(log.shapes, log.tendons, strict=True)
            if tick <= part[-1].tick
        ]
        before = sum(shape.tick <= part[0].tick for shape in shapes)
        return TipPath(
            time=np.array([record.time for record in part]),
            tip=np.array(
                [record.measured or nowhere if kept else nowhere for record, kept in zip(part, drawn, strict=True)]
            ),
            reference=np.array(
                [record.reference.position if record.mode is Mode.TRACKING else nowhere for record in part]
            ),
            target=part[-1].reference.target if tracks else None,
            shapes=shapes[max(0, before - 1) :],
        )

    @cached_property
    def arcs(self) -> Array:
        """Compute the distance travelled by the tip from the first shape to each [m], shape (shapes,)."""
        tips = np.array([shape.points[-1] for shape in self.shapes]).reshape(-1, 3)
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(tips, axis=0), axis=1))])[: len(tips)]

    def chosen(self, count: int) -> list[int]:
        """Select the indices of up to so many shapes, with the first and the last, equally spaced in that distance."""
        last = len(self.shapes) - 1
        if last < count:
            return list(range(last + 1))
        wanted = np.searchsorted(self.arcs, np.linspace(0.0, self.arcs[-1], count - 1))
        return [int(i) for i in np.unique(np.concatenate([wanted, [0, last]]))]

    @property
    def points(self) -> Array:
        """All points to be drawn [m], shape (n, 3)."""
        drawn = [self.tip, self.reference, *(shape.points for shape in self.shapes)]
        if self.target is not None:
            drawn.append(np.array([self.target]))
        stacked = np.vstack(drawn)
        return stacked[np.isfinite(stacked).all(axis=1)]

    @property
    def view(self) -> tuple[float, float]:
        """Elevation and azimuth of the view [deg]: onto the plane of a run that has one, else from a corner."""
        points = self.points
        _, sizes, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
        across = axes[2]
        if sizes[2] > FLAT * sizes[0] or abs(across[2]) > 0.5:
            return 22.0, -55.0
        if across[np.argmax(np.abs(across[:2]))] < 0.0:
            across = -across
        # From the side from which x (or y) runs to the right.
        azimuth = float(np.degrees(np.arctan2(across[1], across[0])))
        return TILT_DEG, (azimuth - 180.0 if abs(across[1]) > abs(across[0]) else azimuth) + TURN_DEG
