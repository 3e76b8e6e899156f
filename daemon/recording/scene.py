"""The picture of the robot in the log: rod, tendons, tip, target and the tip's trail, as Foxglove's scene entities."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.recording.foxglove import (
    Color,
    KeyValuePair,
    LinePrimitive,
    Point3,
    Pose,
    SceneEntity,
    SceneUpdate,
    SpherePrimitive,
    timestamp,
    vector,
)
from tendond.schemas import base

ROD = "rod"
"""Identifier of the rod's scene entity."""

TRAIL = "trail"
"""Identifier of the entity that shows where the tip has been."""

TRAIL_POINTS = 60
"""Points of the trail, one for each shape: three seconds with the default configuration."""

TICK = "tick"
"""Key of the cycle's index in the metadata of the rod's scene entity."""

_ROD_THICKNESS = 0.004  # [m] drawn: twice the default backbone's diameter, to be visible
_MARKER = 0.012  # [m] diameter of the spheres at tip and target
_TENDON_THICKNESS = 0.001  # [m]
_TRAIL_THICKNESS = 0.0015  # [m]
_TRAIL_DECIMALS = 4
_SHAPE_DECIMALS = 6
_SHAPE_POINTS = 50  # to the micrometre, a smooth curve in 2 kB, built in 0.1 ms; 200 points take 0.5 ms


def rod_shape(
    time_ns: int,
    tick: int,
    points: NDArray[np.float64],
    target: base.Vector3,
    tendons: Sequence[NDArray[np.float64]] = (),
    trail: Sequence[base.Vector3] = (),
) -> SceneUpdate:
    """The rod, its tendons, its tip and the target as one entity, the rod its first line; the tip's trail as another.

    Args:
        time_ns: time of the shape [ns].
        tick: index of the cycle.
        points: points of the backbone, base to tip [m], shape (nodes, 3); at most 50 are kept, the ends among them.
        target: where the tip should be [m].
        tendons: points of each one [m], shapes (k, 3).
        trail: where the tip has been, at most `TRAIL_POINTS` [m].
    """
    kept = np.linspace(0, len(points) - 1, min(len(points), _SHAPE_POINTS)).round().astype(np.intp)
    rounded: list[list[float]] = np.round(points[kept], _SHAPE_DECIMALS).tolist()
    steel, orange = Color(r=0.25, g=0.45, b=0.7), Color(r=0.9, g=0.45, b=0.1)
    rod = _line(rounded, _ROD_THICKNESS, steel)
    strings = [
        _line(np.round(path, _SHAPE_DECIMALS).tolist(), _TENDON_THICKNESS, Color(r=0.5, g=0.5, b=0.5))
        for path in tendons
    ]
    return SceneUpdate(
        entities=(
            SceneEntity(
                timestamp=timestamp(time_ns),
                id=ROD,
                metadata=(KeyValuePair(key=TICK, value=str(tick)),),
                lines=(rod, *strings),
                spheres=(_sphere(rounded[-1], steel), _sphere(target, orange)),
            ),
            SceneEntity(timestamp=timestamp(time_ns), id=TRAIL, lines=(_trail(trail),)),
        )
    )


def _trail(points: Sequence[base.Vector3]) -> LinePrimitive:
    rounded = np.round(np.reshape(points, (-1, 3)), _TRAIL_DECIMALS).tolist()
    return _line(rounded, _TRAIL_THICKNESS, Color(r=0.25, g=0.45, b=0.7, a=0.6))


def _line(points: Sequence[Sequence[float]], thickness: float, color: Color) -> LinePrimitive:
    return LinePrimitive(thickness=thickness, points=tuple(Point3(x=x, y=y, z=z) for x, y, z in points), color=color)


def _sphere(centre: Sequence[float], color: Color) -> SpherePrimitive:
    return SpherePrimitive(pose=Pose(position=vector(centre)), size=vector((_MARKER,) * 3), color=color)
