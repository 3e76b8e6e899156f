"""Corners of a tag from its edges: a line through each side of the black square, and their intersections.

A detector's corners are off by half a pixel, and `cornerSubPix` moves the outer corners of a square by a quarter of
one, which is 1 % of the distance of a tag of 40 px. A side has dozens of pixels across which the picture goes from
black to white: the middle of each of these steps, where the weight is the gradient, lies on it whatever the blur (the
refinement of edges of J. Wang, E. Olson, "AprilTag 2", IROS 2016). The lines are fitted in the picture without the
lens' distortion, where they are straight.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from tendond.drivers.apriltag.calibration import distortion, matrix
from tendond.schemas.camera import CameraCalibration

Array = NDArray[np.float64]

ROUNDS = 2
"""Refinements, each from the corners of the one before: the first may start a pixel off."""

REACH = 0.09
"""Largest distance from a side at which the picture is looked at, of the side's length: the black border of a tag is an
eighth of it wide in 36h10 and 36h11, a seventh in 25h9, a sixth in 16h5."""

REACH_PIXELS = (1.5, 4.0)
"""Bounds of that distance [px]: less has no room for the blur of a lens, more takes in neighbours."""

STEP = 0.25
"""Distance of two samples across a side [px]."""

SAMPLES = 32
"""Places along a side; a tag's picture is seldom larger than a few hundred pixels."""

SHARE = 0.7
"""Middle part of a side that is used: the corners' blur would bend it."""

CONTRAST = 10.0
"""Smallest step from black to white that counts [grey levels of 255]."""


def refined(grey: NDArray[np.uint8], corners: Array, camera: CameraCalibration) -> Array | None:
    """Return a tag's corners as a camera without distortion has them [px], shape (4, 2); none without clear edges.

    Args:
        grey: picture, shape (height, width).
        corners: about where they are in it [px], clockwise, shape (4, 2).
        camera: calibration.
    """
    inner, lens = matrix(camera), distortion(camera)
    found = np.asarray(corners, dtype=np.float64)
    for last in (*[False] * (ROUNDS - 1), True):
        lines = []
        for i in range(4):
            points = _edge_points(grey, found[i], found[(i + 1) % 4])
            if points is None:
                return None
            straight = cv2.undistortPoints(points.reshape(-1, 1, 2), inner, lens, P=inner) if last else points
            lines.append(_line(np.asarray(straight, dtype=np.float64).reshape(-1, 2)))
        found = np.array([_meet(lines[i - 1], lines[i]) for i in range(4)])
        if not np.all(np.isfinite(found)):
            return None
    return found


def _edge_points(grey: NDArray[np.uint8], start: Array, end: Array) -> Array | None:
    """Return points of the side between two corners [px], shape (n, 2); none where it is too short or too faint."""
    along = end - start
    length = float(np.linalg.norm(along))
    if length < 8.0:
        return None
    reach = float(np.clip(REACH * length, *REACH_PIXELS))
    outward = np.array([along[1], -along[0]]) / length  # clockwise with y down: the outside is on the left
    offsets = np.arange(-reach, reach + 0.5 * STEP, STEP)
    places = start + np.linspace(0.5 - 0.5 * SHARE, 0.5 + 0.5 * SHARE, SAMPLES)[:, None] * along
    where = (places[:, None, :] + offsets[None, :, None] * outward).astype(np.float32)
    values = np.asarray(cv2.remap(grey, where[..., 0], where[..., 1], cv2.INTER_LINEAR), dtype=np.float64)
    rise = np.maximum(np.diff(values, axis=1), 0.0)
    total = rise.sum(axis=1)
    clear = total > CONTRAST
    if np.count_nonzero(clear) < SAMPLES // 2:
        return None
    weight = rise[clear] ** 2
    middle = 0.5 * (offsets[1:] + offsets[:-1])
    at = (weight @ middle) / weight.sum(axis=1)
    return np.asarray(places[clear] + at[:, None] * outward)


def _line(points: Array) -> Array:
    """Fit a line a x + b y + c = 0 by least squares of the distances, shape (3,)."""
    centre = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - centre, full_matrices=False)
    normal = axes[1]
    return np.array([*normal, -normal @ centre])


def _meet(one: Array, other: Array) -> Array:
    """Intersection of two lines, shape (2,); not finite for parallel ones."""
    x, y, w = np.cross(one, other)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.array([x / w, y / w], dtype=np.float64)
