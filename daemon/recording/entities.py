"""Foxglove's scene: entities to draw and their primitives, as far as tendond writes them; see `foxglove`."""

from enum import IntEnum

from tendond.daemon.recording.foxglove import FRAME, Duration, Natural, Point3, Pose, Time, Vector3, WellKnown

ROD = "rod"
"""Identifier of the rod's scene entity."""

TICK = "tick"
"""Key of the cycle's index in the metadata of the rod's scene entity."""


class Color(WellKnown):
    """Red, green, blue, alpha, 0 to 1."""

    r: float
    g: float
    b: float
    a: float = 1.0


class KeyValuePair(WellKnown):
    """Key and value in an entity's metadata."""

    key: str
    value: str


class ArrowPrimitive(WellKnown):
    """An arrow along +x of its pose, from the tail; lengths and diameters [m]."""

    pose: Pose
    shaft_length: float
    shaft_diameter: float
    head_length: float
    head_diameter: float
    color: Color


class CylinderPrimitive(WellKnown):
    """A cylinder along z of its pose, about its centre; size: diameters and length [m], scales: of its ends."""

    pose: Pose
    size: Vector3
    bottom_scale: float = 1.0
    top_scale: float = 1.0
    color: Color


class SpherePrimitive(WellKnown):
    """A sphere; size: diameters [m]."""

    pose: Pose
    size: Vector3
    color: Color


class LineType(IntEnum):
    """Manner in which points are joined."""

    LINE_STRIP = 0
    LINE_LOOP = 1
    LINE_LIST = 2


class LinePrimitive(WellKnown):
    """A line through points [m]; thickness [m], or pixels where scale_invariant."""

    type: LineType = LineType.LINE_STRIP
    pose: Pose = Pose()
    thickness: float
    scale_invariant: bool = False
    points: tuple[Point3, ...]
    color: Color
    colors: tuple[Color, ...] = ()
    indices: tuple[Natural, ...] = ()


class Unused(WellKnown):
    """A primitive that tendond does not draw; its list must be there, empty."""


class SceneEntity(WellKnown):
    """Things to draw; replaces the entity of the same id."""

    timestamp: Time
    frame_id: str = FRAME
    id: str
    lifetime: Duration = Duration()
    frame_locked: bool = True
    metadata: tuple[KeyValuePair, ...] = ()
    arrows: tuple[ArrowPrimitive, ...] = ()
    cubes: tuple[Unused, ...] = ()
    spheres: tuple[SpherePrimitive, ...] = ()
    cylinders: tuple[CylinderPrimitive, ...] = ()
    lines: tuple[LinePrimitive, ...] = ()
    triangles: tuple[Unused, ...] = ()
    texts: tuple[Unused, ...] = ()
    models: tuple[Unused, ...] = ()


class SceneUpdate(WellKnown):
    """Entities to add or replace."""

    deletions: tuple[Unused, ...] = ()
    entities: tuple[SceneEntity, ...]
