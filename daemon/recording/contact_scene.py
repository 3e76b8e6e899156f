"""A contact along the body, as an entity of Foxglove's scene: where it may be, and its force."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.recording.entities import Color, LinePrimitive, SceneEntity, SpherePrimitive
from tendond.daemon.recording.foxglove import Point3, Pose, timestamp, vector
from tendond.daemon.recording.scene import force_primitives
from tendond.schemas.base import Vector3

Array = NDArray[np.float64]

CONTACT = "contact"
"""Identifier of the entity that shows a contact."""

_STRETCH, _BALL = 0.008, 0.014  # [m] thickness of the stretch that is not excluded, diameter of the likeliest place
_POINTS = 12  # of the stretch


def contact_entity(
    time_ns: int, points: Array, length: float, places: Sequence[float], force: Vector3, deviation: Vector3
) -> SceneEntity:
    """Draw a contact: a ball at the likeliest place, a thick line over those not excluded, and its force.

    Args:
        time_ns: time of the shape [ns].
        points: evenly spaced points of the backbone [m], shape (k, 3). length: of the robot [m].
        places: arc lengths of the likeliest place, and of the first and the last that the data do not exclude [m].
        force: [N]; deviation: standard deviation of each component [N]; drawn as `scene.FORCE_SCALE` says.
    """
    place, first, last = places
    x, y, z = _at(points, length, np.array([place]))[0].tolist()
    stretch = _at(points, length, np.linspace(first, last, _POINTS)).tolist()
    purple = Color(r=0.5, g=0.1, b=0.6, a=0.6)
    line = LinePrimitive(thickness=_STRETCH, points=tuple(Point3(x=a, y=b, z=c) for a, b, c in stretch), color=purple)
    ball = SpherePrimitive(pose=Pose(position=vector((x, y, z))), size=vector((_BALL,) * 3), color=purple)
    dx, dy, dz = (one**2 for one in deviation)
    arrows, cylinders = force_primitives((x, y, z), force, (dx, 0.0, 0.0, dy, 0.0, dz))
    return SceneEntity(
        timestamp=timestamp(time_ns), id=CONTACT, lines=(line,), spheres=(ball,), arrows=arrows, cylinders=cylinders
    )


def no_contact(time_ns: int) -> SceneEntity:
    """Return the entity without anything to draw: it takes the place of one that was there."""
    return SceneEntity(timestamp=timestamp(time_ns), id=CONTACT)


def _at(points: Array, length: float, places: Array) -> Array:
    """Return points of the backbone at arc lengths [m], shape (p, 3)."""
    along = np.linspace(0.0, length, len(points))
    return np.stack([np.interp(places, along, points[:, axis]) for axis in range(3)], axis=1)
