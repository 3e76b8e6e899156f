"""References of poses: stretches of paths with their timing, and what a task asks of them."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.pose.path import POSITION, PosePath
from tendond.daemon.control.pose.pose import Aim, Miss, Pose
from tendond.daemon.control.reference.goal import Goal
from tendond.daemon.control.reference.stretches import Stretches
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
        displacement_rate: of the tendons [m/s], shape (n,); none where it is not planned.
        tension: that holds the robot there at rest [N], shape (n,); none where it is not planned.
    """

    pose: Pose
    velocity: Array
    acceleration: Array
    displacement_rate: Array | None
    tension: Array | None


@dataclass(frozen=True)
class PlannedGoal(PoseGoal):
    """A pose on a planned way, with what the tendons do there."""

    displacement_rate: Array
    tension: Array


@dataclass(frozen=True)
class PoseReference(Stretches[PosePath]):
    """A trajectory of poses that the resting robot reaches.

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

    def at(self, time: float) -> ReferencePoint:
        """Evaluate the tip's position at `time` [s] since tracking began."""
        path, (place, speed, acceleration) = self.locate(time)
        value, first, second = path.at(place)
        position = path.pose(value).position
        return self.passing(position, first[POSITION], second[POSITION], speed, acceleration)

    def goal(self, time: float) -> Goal:
        """Evaluate the tip's position at `time` [s], for a law that follows it alone."""
        return Goal(self.pose(time).pose.position, None)

    def pose(self, time: float) -> PlannedGoal:
        """Evaluate the pose at `time` [s] since tracking began."""
        path, (place, speed, acceleration) = self.locate(time)
        value, first, second = path.at(place)
        return PlannedGoal(
            pose=path.pose(value),
            velocity=first[POSITION] * speed,
            acceleration=second[POSITION] * speed**2 + first[POSITION] * acceleration,
            displacement_rate=first[path.displacement] * speed,
            tension=value[path.tension],
        )
