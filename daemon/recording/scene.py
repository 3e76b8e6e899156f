"""The picture of the robot in the log, as Foxglove's scene entities: rod, tendons, tip, target and the tip's trail.

With an observer of kind 'kalman' there is another entity: what it knows of tip and force.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.estimation.spread import deviation_along, ellipsoid
from tendond.daemon.recording.entities import (
    ROD,
    TICK,
    ArrowPrimitive,
    Color,
    CylinderPrimitive,
    KeyValuePair,
    LinePrimitive,
    SceneEntity,
    SceneUpdate,
    SpherePrimitive,
)
from tendond.daemon.recording.foxglove import Point3, Pose, Quaternion, timestamp, vector
from tendond.model.numerics.rotation import quaternion
from tendond.schemas import base
from tendond.schemas.record import Covariance, ObserverEstimate

Array = NDArray[np.float64]

TRAIL = "trail"
"""Identifier of the entity that shows where the tip has been."""

FILTER = "filter"
"""Identifier of the entity that shows what the filter knows."""

FORCE_SCALE = 0.1
"""Length of a force's arrow [m/N]: a weight of 50 g on the paper's robot of 0.5 m is drawn with 5 cm. Chosen."""

TRAIL_POINTS = 60
"""Points of the trail, one for each shape: three seconds with the default configuration."""

_ROD_THICKNESS = 0.004  # [m] drawn: twice the default backbone's diameter, to be visible
_MARKER = 0.012  # [m] diameter of the spheres at tip and target
_TENDON_THICKNESS = 0.001  # [m]
_TRAIL_THICKNESS = 0.0015  # [m]
_ARROW, _ARROW_HEAD = 0.003, 0.009  # [m] diameters; the head is as long as wide
_THIN = 1e-4  # [m] smallest diameter of an ellipsoid, to be visible
_TRAIL_DECIMALS = 4
_SHAPE_DECIMALS = 6
_SHAPE_POINTS = 50  # to the micrometre, a smooth curve in 2 kB, built in 0.1 ms; 200 points take 0.5 ms


def rod_shape(
    time_ns: int,
    tick: int,
    points: Array,
    target: base.Vector3,
    tendons: Sequence[Array] = (),
    trail: Sequence[base.Vector3] = (),
    others: Sequence[SceneEntity] = (),
) -> SceneUpdate:
    """The rod, its tendons, its tip and the target as one entity, the rod its first line; the tip's trail as another.

    Args:
        time_ns: time of the shape [ns].
        tick: index of the cycle.
        points: points of the backbone, base to tip [m], shape (nodes, 3); at most 50 are kept, the ends among them.
        target: where the tip should be [m].
        tendons: points of each one [m], shapes (k, 3).
        trail: where the tip has been, at most `TRAIL_POINTS` [m].
        others: further entities, see `filter_entities`.
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
            *others,
        )
    )


def filter_entities(time_ns: int, tip: base.Vector3, observer: ObserverEstimate) -> tuple[SceneEntity, ...]:
    """What the filter knows, as an entity; none where the observer has no filter.

    Its sphere is the ellipsoid that holds the tip with 95 %, its arrow the force on the tip, `FORCE_SCALE` long, and
    its cylinder, about the arrow's end, one standard deviation of the force to each side.

    Args:
        time_ns: time of the shape [ns].
        tip: of the model [m].
        observer: of the record.
    """
    known = observer.filter
    if known is None:
        return ()
    return (filter_entity(time_ns, tip, observer.force, known.tip_covariance, known.force_covariance),)


def filter_entity(
    time_ns: int, tip: base.Vector3, force: base.Vector3, tip_covariance: Covariance, force_covariance: Covariance
) -> SceneEntity:
    """Draw what the filter knows; see `filter_entities`, and `FilterEstimate` for the covariances."""
    half_axes, axes = ellipsoid(tip_covariance)
    sizes = np.maximum(2.0 * half_axes, _THIN)
    bound = SpherePrimitive(pose=_posed(tip, axes), size=vector(sizes.tolist()), color=_red(0.35))
    arrows, cylinders = force_primitives(tip, force, force_covariance)
    scale = KeyValuePair(key="force_scale_m_per_n", value=str(FORCE_SCALE))
    return SceneEntity(
        timestamp=timestamp(time_ns),
        id=FILTER,
        metadata=(scale,),
        arrows=arrows,
        spheres=(bound,),
        cylinders=cylinders,
    )


def force_primitives(
    place: base.Vector3, force: base.Vector3, covariance: Covariance
) -> tuple[tuple[ArrowPrimitive, ...], tuple[CylinderPrimitive, ...]]:
    """Draw a force [N] at a place [m]: an arrow, and about its end one standard deviation; nothing of none."""
    pushed = np.array(force)
    size = float(np.linalg.norm(pushed))
    if size == 0.0:
        return (), ()
    turn = _frame_along(pushed / size)
    head = min(_ARROW_HEAD, FORCE_SCALE * size)
    arrow = ArrowPrimitive(
        pose=_posed(place, turn),
        shaft_length=FORCE_SCALE * size - head,
        shaft_diameter=_ARROW,
        head_length=head,
        head_diameter=_ARROW_HEAD,
        color=_red(1.0),
    )
    deviation = CylinderPrimitive(
        pose=_posed((np.array(place) + FORCE_SCALE * pushed).tolist(), np.roll(turn, -1, axis=1)),
        size=vector((_ARROW, _ARROW, 2.0 * FORCE_SCALE * deviation_along(covariance, pushed))),
        color=_red(0.35),
    )
    return (arrow,), (deviation,)


def _frame_along(direction: Array) -> Array:
    """Return a rotation, shape (3, 3), whose x is the direction, shape (3,)."""
    side = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    side /= np.linalg.norm(side)
    return np.column_stack((direction, side, np.cross(direction, side)))


def _posed(position: Sequence[float], rotation: Array) -> Pose:
    w, x, y, z = quaternion(rotation)
    return Pose(position=vector(position), orientation=Quaternion(x=x, y=y, z=z, w=w))


def _red(alpha: float) -> Color:
    return Color(r=0.75, g=0.15, b=0.2, a=alpha)


def _trail(points: Sequence[base.Vector3]) -> LinePrimitive:
    rounded = np.round(np.reshape(points, (-1, 3)), _TRAIL_DECIMALS).tolist()
    return _line(rounded, _TRAIL_THICKNESS, Color(r=0.25, g=0.45, b=0.7, a=0.6))


def _line(points: Sequence[Sequence[float]], thickness: float, color: Color) -> LinePrimitive:
    return LinePrimitive(thickness=thickness, points=tuple(Point3(x=x, y=y, z=z) for x, y, z in points), color=color)


def _sphere(centre: Sequence[float], color: Color) -> SpherePrimitive:
    return SpherePrimitive(pose=Pose(position=vector(centre)), size=vector((_MARKER,) * 3), color=color)
