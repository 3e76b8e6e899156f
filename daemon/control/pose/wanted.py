"""Poses that a [reference] asks for: what counts of them, and their timing."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from tendond.daemon.control.pose.pose import Aim, Pose, rotation_to
from tendond.daemon.control.reference.shapes import shape_of
from tendond.daemon.control.reference.time_scaling import Timing, as_given, minimum_jerk, steady
from tendond.daemon.errors import TargetError
from tendond.schemas.config.reference import ReferenceSection

Array = NDArray[np.float64]

PER_TURN, PER_SECOND, PER_PIECE, POSES_MAX = 48, 20.0, 8, 2000
"""Poses on a turn of a curve, in a second of samples and between two waypoints, and their largest number."""


@dataclass(frozen=True)
class Wanted:
    """Poses in a row, and how they are passed.

    Attributes:
        poses: one for a single target.
        counts: what of them is prescribed.
        length: parameter of the last one.
        timing: of the trajectory; none for a single target.
    """

    poses: list[Pose]
    counts: Aim
    length: float
    timing: Timing | None


def wanted_poses(section: ReferenceSection) -> Wanted:
    """Return what a section in space asks for.

    Raises:
        TargetError: a direction or a quaternion of no length, or a file that has not been read.
    """
    if section.kind in ("pose", "point"):
        assert section.position is not None
        row = np.array([*section.position, *(section.direction or ()), *(section.orientation or ())])
        poses, counts = _poses(row[None, :])
        return Wanted(poses, counts, 0.0, None)
    if section.kind == "path":
        if not section.waypoints:
            raise TargetError(f"reference.file = '{section.file}' has not been read: give the configuration as a file")
        table = np.array(section.waypoints)
        count = min(PER_PIECE * (len(table) - 1) + 1, POSES_MAX)
        poses, counts = _poses(_between(np.linspace(0.0, 1.0, len(table)), table, np.linspace(0.0, 1.0, count)))
        return Wanted(poses, counts, 1.0, minimum_jerk(1.0, section.duration))
    if section.kind == "samples":
        table = np.array(section.samples)
        end = float(table[-1, 0])
        count = min(max(len(table), math.ceil(end * PER_SECOND) + 1), POSES_MAX)
        poses, counts = _poses(_between(table[:, 0], table[:, 1:], np.linspace(0.0, end, count)))
        return Wanted(poses, counts, end, as_given(end))
    shape = shape_of(section)
    turns = np.linspace(0.0, section.laps, PER_TURN * section.laps + 1)
    places = [shape(float(turn)) for turn in turns]
    counts = "across" if len(places[0]) == 2 else "position"
    poses = [Pose(np.append(place, 0.0)[:3], np.eye(3)) for place in places]
    return Wanted(poses, counts, float(section.laps), steady(section.laps, section.period))


def _between(at: Array, table: Array, wanted: Array) -> Array:
    """Return rows between those of a table, by a cubic spline at rest at both ends."""
    table = table.copy()
    if table.shape[1] == 7:  # q and -q are the same orientation
        for k in range(1, len(table)):
            if float(table[k, 3:] @ table[k - 1, 3:]) < 0.0:
                table[k, 3:] *= -1.0
    return np.asarray(CubicSpline(at, table, bc_type="clamped")(wanted))


def _poses(rows: Array) -> tuple[list[Pose], Aim]:
    """Return poses of rows of x, y, z [m], with a direction or a quaternion w, x, y, z behind, if any."""
    positions, turns = rows[:, :3], rows[:, 3:]
    width = turns.shape[1]
    if width == 0:
        return [Pose(one, np.eye(3)) for one in positions], "position"
    sizes = np.linalg.norm(turns, axis=1)
    if float(sizes.min()) < 1e-6:
        raise TargetError(f"reference: direction or quaternion {int(np.argmin(sizes))} is zero: give one of length 1")
    turns = turns / sizes[:, None]
    if width == 3:
        return [Pose(one, rotation_to(turn)) for one, turn in zip(positions, turns, strict=True)], "direction"
    rotations = Rotation.from_quat(turns[:, [1, 2, 3, 0]]).as_matrix()
    return [Pose(one, rotation) for one, rotation in zip(positions, rotations, strict=True)], "pose"
