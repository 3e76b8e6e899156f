"""Trajectories in stretches, one after the other: the approach, and the trajectory proper."""

from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.reference.time_scaling import Timing
from tendond.schemas.base import Vector3
from tendond.schemas.record import ReferencePoint

Array = NDArray[np.float64]
Path = TypeVar("Path")


class Stretches(Generic[Path]):
    """Times of a trajectory.

    Attributes:
        stretches: paths, and the progress along each. target: final position of the tip [m].
    """

    stretches: tuple[tuple[Path, Timing], ...]
    target: Vector3

    @property
    def arrival(self) -> float:
        """Time from which on it rests [s]."""
        return sum(timing.end for _, timing in self.stretches)

    @property
    def approach_time(self) -> float:
        """Duration of the approach [s], after which the trajectory proper begins."""
        return self.stretches[0][1].end if len(self.stretches) > 1 else 0.0

    def locate(self, time: float) -> tuple[Path, tuple[float, float, float]]:
        """Return the path at a time [s], and the place, speed and acceleration along it."""
        for path, timing in self.stretches[:-1]:
            if time < timing.end:
                return path, timing.progress(time)
            time -= timing.end
        path, timing = self.stretches[-1]
        return path, timing.progress(time)

    def passing(self, value: Array, first: Array, second: Array, speed: float, acceleration: float) -> ReferencePoint:
        """Return the point of a path [m], with its derivatives by the place, passed with speed and acceleration."""
        rows = np.array([value, first * speed, second * speed**2 + first * acceleration]).tolist()
        return ReferencePoint.trusted(
            position=tuple(rows[0]), velocity=tuple(rows[1]), acceleration=tuple(rows[2]), target=self.target
        )
