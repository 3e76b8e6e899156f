"""A base that moves: its measured poses, and what a camera sees, taken into the base's frame at its own time.

A tip's pose and markers come in the frame in which the base is configured, as the base's own pose does. The rod's model
stands in the base's frame, so each is turned and shifted by the newest reading of the base that is not younger than it.
Of the base's motion that is all: the rod's inertia and gravity are those of a base that stands as configured.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tendond.daemon.control.sensors import Reading, Row, Sensor
from tendond.schemas.base import Quaternion, Vector3
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import TipPose

Array = NDArray[np.float64]

KEPT = 0.55
"""Age up to which readings of the base are kept [s]: the longest configured delay, and a little more."""


@dataclass(frozen=True)
class BasePose:
    """A measured pose of the base.

    Attributes:
        age: since it was taken, now [s].
        position: in the frame in which the base is configured [m].
        orientation: unit quaternion w, x, y, z, base to that frame.
    """

    age: float
    position: Vector3
    orientation: Quaternion


def base_name(sensors: dict[str, Sensor]) -> str | None:
    """Return the name of the sensor that measures the base: the first of its kind; none where there is none."""
    return next((name for name, one in sensors.items() if one.section.kind == "base"), None)


def base_deviations(config: RigConfig) -> tuple[float, float]:
    """Return the standard deviations of the base's position [m] and rotation vector [rad]; zero without readings."""
    found = next((one for one in config.sensors if one.kind == "base"), None)
    return (0.0, 0.0) if found is None else (found.deviations[0], found.deviations[3])


def base_poses(
    known: tuple[BasePose, ...], name: str, admitted: Iterable[Reading], elapsed: float
) -> tuple[BasePose, ...]:
    """Return the poses of the base that are known now, the youngest first.

    Args:
        known: those of the last cycle. elapsed: since then [s].
        name: of the base's sensor.
        admitted: readings of this cycle.
    """
    poses = [BasePose(one.age + elapsed, one.position, one.orientation) for one in known]
    for reading in admitted:
        row = reading.rows[0] if reading.name == name else None
        if row is not None:
            x, y, z, *turned = row
            a, b, c, d = (part / math.hypot(*turned) for part in turned)
            poses.append(BasePose(reading.age, (x, y, z), (a, b, c, d)))
    poses.sort(key=lambda one: one.age)
    young = sum(one.age <= KEPT for one in poses)
    return tuple(poses[: young + 1])  # the one before them holds until the oldest of them


def base_at(poses: tuple[BasePose, ...], age: float, slack: float) -> BasePose | None:
    """Return the newest pose of the base that is not younger than `age` [s] by more than `slack` [s].

    Where all are younger it is the oldest; none where nothing has been read yet.
    """
    return next((one for one in poses if one.age >= age - slack), poses[-1] if poses else None)


def pose_in_base(pose: TipPose, base: BasePose | None) -> TipPose:
    """Return a tip's pose in the base's frame; as it is where the base has not been measured yet."""
    if base is None:
        return pose
    (position,) = _moved([pose.position], base)
    turned = pose.orientation
    if turned is not None:
        w, x, y, z = turned
        a, b, c, d = (_rotation(base).inv() * Rotation.from_quat((x, y, z, w))).as_quat().tolist()
        turned = (d, a, b, c)
    return pose.model_copy(update={"position": position, "orientation": turned})


def readings_in_base(
    sensors: dict[str, Sensor], admitted: tuple[Reading, ...], poses: tuple[BasePose, ...], slack: float
) -> tuple[Reading, ...]:
    """Return readings with the rows of markers in the base's frame; arguments as of `base_poses` and `base_at`."""
    return tuple(
        Reading(one.name, _rows_in_base(one.rows, base_at(poses, one.age, slack)), one.age)
        if sensors[one.name].section.kind == "markers"
        else one
        for one in admitted
    )


def _rows_in_base(rows: tuple[Row, ...], base: BasePose | None) -> tuple[Row, ...]:
    seen = [(row[0], row[1], row[2]) for row in rows if row is not None]
    if base is None or not seen:
        return rows
    moved = iter(_moved(seen, base))
    return tuple(None if row is None else next(moved) for row in rows)


def _moved(places: list[Vector3], base: BasePose) -> list[Vector3]:
    """Return places in the base's frame [m]."""
    own = (np.array(places) - np.array(base.position)) @ _rotation(base).as_matrix()
    return [(x, y, z) for x, y, z in own.tolist()]


def _rotation(base: BasePose) -> Rotation:
    w, x, y, z = base.orientation
    return Rotation.from_quat((x, y, z, w))
