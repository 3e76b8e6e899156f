"""Pose of a square tag from its four corners: both solutions, weighed by reprojection and continuity.

A small or distant plane has two poses that project nearly alike, mirrored about the line of sight (G. Schweighofer,
A. Pinz, "Robust pose estimation from a planar target", IEEE TPAMI 28, 2006). OpenCV's IPPE_SQUARE gives both (T.
Collins, A. Bartoli, "Infinitesimal plane-based pose estimation", IJCV 109, 2014); a single picture may prefer the wrong
one. So each solution carries a cost: its reprojection error in units of the corners' noise, and the cheapest way to it
from a solution of the last picture, at a cost for the rotation between them. This is the dynamic program of A. Viterbi
(1967) over two hypotheses, with a fading memory.
"""

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from tendond.drivers.apriltag.calibration import matrix
from tendond.drivers.mocap.geometry import Placement
from tendond.schemas.camera import CameraCalibration

Array = NDArray[np.float64]

CORNER_NOISE = 0.3
"""Standard deviation of a corner's coordinate [px]; 0.05 on rendered pictures, printed tags and lenses are worse."""

RATE = 3.0
"""Standard deviation of the tip's rate of turn [rad/s], for the cost of a rotation between two pictures; chosen: half a
turn in a second is fast for a rod, and less than half of the usual distance of the two solutions in 0.1 s."""

ANGLE = 0.05
"""Standard deviation of the rotation between two pictures beside that [rad], of the noise of a tag's pose."""

MEMORY = 0.9
"""Part of a solution's cost that counts in the next picture: ten pictures."""

GAP_SECONDS = 0.5
"""Time without the tag after which the last solutions count no more [s]."""


@dataclass(frozen=True)
class Solution:
    """A pose of a tag in the camera's frame, and its reprojection error, root mean square over the corners [px]."""

    placement: Placement
    error: float


@dataclass
class TagPose:
    """Pose of one tag, picture by picture.

    Attributes:
        camera: calibration.
        size: side of the black square [m].
    """

    camera: CameraCalibration
    size: float
    _costs: list[tuple[Solution, float]] = field(default_factory=list)
    _at: float = -math.inf

    def update(self, corners: Array, at: float) -> Solution | None:
        """Return the pose in a picture; none where the corners have none.

        Args:
            corners: corners of the black square as a camera without distortion has them [px], clockwise from the tag's
                top left, shape (4, 2).
            at: time of the picture [s].
        """
        found = solutions(corners, self.size, self.camera)
        if not found:
            return None
        elapsed = at - self._at
        before = self._costs if 0.0 <= elapsed <= GAP_SECONDS else []
        spread = math.hypot(ANGLE, RATE * elapsed) if before else 1.0
        costs = []
        for one in found:
            cost = 2.0 * (one.error / CORNER_NOISE) ** 2  # four corners: sum of squares / (2 sigma^2)
            if before:
                cost += min(
                    MEMORY * past + 0.5 * (angle(one.placement, other.placement) / spread) ** 2
                    for other, past in before
                )
            costs.append((one, cost))
        least = min(cost for _, cost in costs)
        self._costs, self._at = [(one, cost - least) for one, cost in costs], at
        return min(costs, key=lambda pair: pair[1])[0]


def solutions(corners: Array, size: float, camera: CameraCalibration) -> list[Solution]:
    """Return the one or two poses of a tag, the one with the smaller reprojection error first.

    Args:
        corners: as in `TagPose.update`, shape (4, 2). size: side of the black square [m].
    """
    half = 0.5 * size
    square = np.array([[-half, half, 0.0], [half, half, 0.0], [half, -half, 0.0], [-half, -half, 0.0]])
    inner, lens = matrix(camera), np.zeros(5)
    picture = np.ascontiguousarray(corners, dtype=np.float64).reshape(4, 1, 2)
    try:
        _, turns, shifts, _ = cv2.solvePnPGeneric(square, picture, inner, lens, flags=cv2.SOLVEPNP_IPPE_SQUARE)
    except cv2.error:  # corners on one line, for instance
        return []
    found = []
    for turn, shift in zip(turns, shifts, strict=True):
        turn, shift = cv2.solvePnPRefineLM(square, picture, inner, lens, turn, shift)
        seen, _ = cv2.projectPoints(square, turn, shift, inner, lens)
        error = float(np.sqrt(np.mean(np.sum((np.asarray(seen) - picture) ** 2, axis=-1))))
        position = np.asarray(shift, dtype=np.float64).reshape(3)
        rotation = np.asarray(cv2.Rodrigues(turn)[0], dtype=np.float64)
        if math.isfinite(error) and np.all(np.isfinite(position)) and np.all(np.isfinite(rotation)) and position[2] > 0:
            found.append(Solution(Placement(position, rotation), error))
    return sorted(found, key=lambda one: one.error)


def angle(one: Placement, other: Placement) -> float:
    """Angle of the rotation between two placements [rad]."""
    cosine = 0.5 * (float(np.trace(one.rotation.T @ other.rotation)) - 1.0)
    return math.acos(max(-1.0, min(1.0, cosine)))
