"""Goals of a law of poses: those of a reference of poses, and of references that prescribe less."""

import math

import numpy as np

from tendond.daemon.control.pose.pose import Aim, Pose, rotation_to
from tendond.daemon.control.pose.reference import PoseGoal, PoseReference
from tendond.daemon.control.reference.planar import PlanarReference
from tendond.daemon.control.reference.reference import Reference

FOLDED = 0.5
"""Motion of the resting tip across, over that along, below which a target across counts as folded: bent by more than
about a right angle. Chosen: beyond, tensions that differ much give nearly the same place across."""


def counts_of(reference: Reference) -> Aim:
    """Return what of the tip's pose a reference prescribes, for laws that move it with all tendons.

    Of a target across, the place along the straight robot is what comes with it. It leads where the arm is folded so
    far that moving along its rests hardly moves it across.
    """
    if isinstance(reference, PoseReference):
        return reference.counts
    if isinstance(reference, PlanarReference) and reference.load_offset is not None and reference.arc is not None:
        across, along = reference.curve.at(reference.arc)[1].tolist()
        side = math.copysign(1.0, float(reference.curve.angle[-1]))
        if side * across > FOLDED * abs(along):
            return "across"
    return "turned" if reference.aim == "direction" else "position"


def goal_at(reference: Reference, time: float, offset: float = 0.0) -> PoseGoal:
    """Evaluate the goal; only what counts of its pose has a meaning.

    Args:
        reference: trajectory. time: since tracking began [s]. offset: by which it yields along the straight rod [m].
    """
    if isinstance(reference, PoseReference):
        return reference.pose(time)
    point = reference.at(time)
    turned = reference.aim == "direction"
    place = np.array(point.position) + np.array([0.0, 0.0, offset])
    return PoseGoal(
        pose=Pose(place, rotation_to(reference.goal(time).place) if turned else np.eye(3)),
        velocity=np.array(point.velocity),
        acceleration=np.array(point.acceleration),
        displacement_rate=None,
        tension=None,
    )
