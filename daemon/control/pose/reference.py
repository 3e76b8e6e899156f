"""References of poses: stretches of paths with their timing, and what a task asks of them."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.pose.path import POSITION, PosePath
from tendond.daemon.control.pose.pose import Aim, Miss, Pose
from tendond.daemon.control.reference.goal import Goal
from tendond.daemon.control.reference.time_scaling import Timing
from tendond.schemas.base import Vector3
from tendond.schemas.record import ReferencePoint

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PoseGoal:
    """A pose on the way, and the motion there of the resting robot.

    Attributes:
        pose: of the tip.
        velocity, acceleration: of the tip's position [m/s, m/s^2], shape (3,).
        displacement_rate: of the tendons [m/s], shape (n,).
        tension: that holds the robot there at rest [N], shape (n,).
    """

    pose: Pose
    velocity: Array
    acceleration: Array
    displacement_rate: Array
    tension: Array


@dataclass(frozen=True)
class PoseReference:
    """A trajectory of poses that the resting robot reaches: the approach, and the trajectory proper.

    Attributes:
        counts: what of a pose is prescribed; the rest of it is what comes with least tension.
        stretches: paths, and the progress along each.
        target: final position of the tip [m].
        moved: largest distance and angle by which the trajectory was moved.
        notes: changes made to it, for the operator.
        aim: 'position', for laws that do not follow directions.
        load_offset: none: every component was asked for.
    """

    counts: Aim
    stretches: tuple[tuple[PosePath, Timing], ...]
    target: Vector3
    moved: Miss
    notes: tuple[str, ...]
    aim: Literal["position"] = "position"
    load_offset: None = None

    @property
    def arrival(self) -> float:
        """Time from which on it rests [s]."""
        return sum(timing.end for _, timing in self.stretches)

    @property
    def approach_time(self) -> float:
        """Duration of the approach [s], after which the trajectory proper begins."""
        return self.stretches[0][1].end if len(self.stretches) > 1 else 0.0

    def at(self, time: float) -> ReferencePoint:
        """Evaluate the tip's position at `time` [s] since tracking began."""
        goal = self.pose(time)
        rows = np.array([goal.pose.position, goal.velocity, goal.acceleration]).tolist()
        return ReferencePoint.trusted(
            position=tuple(rows[0]), velocity=tuple(rows[1]), acceleration=tuple(rows[2]), target=self.target
        )

    def goal(self, time: float) -> Goal:
        """Evaluate the tip's position at `time` [s], for a law that follows it alone."""
        return Goal(self.pose(time).pose.position, None)

    def pose(self, time: float) -> PoseGoal:
        """Evaluate the pose at `time` [s] since tracking began."""
        path, (place, speed, acceleration) = self._locate(time)
        value, first, second = path.at(place)
        return PoseGoal(
            pose=path.pose(value),
            velocity=first[POSITION] * speed,
            acceleration=second[POSITION] * speed**2 + first[POSITION] * acceleration,
            displacement_rate=first[path.displacement] * speed,
            tension=value[path.tension],
        )

    def _locate(self, time: float) -> tuple[PosePath, tuple[float, float, float]]:
        for path, timing in self.stretches[:-1]:
            if time < timing.end:
                return path, timing.progress(time)
            time -= timing.end
        path, timing = self.stretches[-1]
        return path, timing.progress(time)
