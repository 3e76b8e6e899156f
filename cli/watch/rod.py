"""Sketch of the rod from the tip's pose alone."""

from tendond.cli.watch.canvas import Point
from tendond.schemas.base import Quaternion, Vector3

POINTS = 40


def sketch(position: Vector3, orientation: Quaternion, length: float, across: int) -> list[Point]:
    """Draw a cubic from the base, along z, to the tip, along the tip's axis; projected on the plane of one axis and z.

    Args:
        position: tip position [m]. orientation: tip orientation, w, x, y, z.
        length: rod length [m], which scales the directions at the ends.
        across: 0 for the x-z plane, 1 for y-z.
    """
    w, x, y, z = orientation
    axis = (2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y))
    points = []
    for i in range(POINTS + 1):
        s = i / POINTS
        start, end = s * (1.0 - s) ** 2 * length, s * s * (s - 1.0) * length
        tip = s * s * (3.0 - 2.0 * s)
        points.append((tip * position[across] + end * axis[across], tip * position[2] + start + end * axis[2]))
    return points
