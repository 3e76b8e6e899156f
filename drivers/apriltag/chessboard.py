"""Intrinsics of a camera from views of a chessboard, refused where the views do not determine them.

The method is that of Z. Zhang, "A flexible new technique for camera calibration" (IEEE TPAMI 22, 2000), as in OpenCV:
views of a plane at three or more different tilts determine focal lengths and centre; corners near the edges of the
picture the lens. Views from the front alone fit perfectly with any focal length, so a small reprojection error is not
enough: the tilts, the covered part and the standard deviation of the focal length are checked too.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tendond.drivers.apriltag.calibration import CameraError
from tendond.schemas.camera import CameraCalibration

Array = NDArray[np.float64]

VIEWS_MIN = 8
"""Smallest number of distinct views: two determine a camera in principle (Zhang 2000), the others average noise."""

MOVED_MIN = 0.04
"""Smallest mean shift of the corners, of the picture's diagonal, between two distinct views."""

COVERED_MIN = 0.5
"""Smallest part of width and height over which corners are spread: of what lies outside, the lens is extrapolated."""

TILT_MIN = math.radians(20.0)
"""Smallest angle between the two most different views of the board; chosen: a tilt of 10 degrees to either side."""

FOCAL_DEVIATION_MAX = 0.01
"""Largest standard deviation of a focal length, relative: a distance is wrong by as much."""

ERROR_MAX = 1.0
"""Largest reprojection error [px]; corners are found to a tenth of a pixel, so board or pictures are not right."""


@dataclass
class BoardViews:
    """Distinct views of a board.

    Attributes:
        columns, rows: inner corners of the board, where four squares meet.
        square: side of a square [m].
        names: names of the views.
        similar: views that were dropped for being like another.
        blank: pictures without the whole board.
    """

    columns: int
    rows: int
    square: float
    names: list[str] = field(default_factory=list)
    similar: int = 0
    blank: int = 0
    _corners: list[Array] = field(default_factory=list)
    _size: tuple[int, int] | None = None

    def add(self, grey: NDArray[np.uint8], name: str) -> bool:
        """Add a picture, shape (height, width); return whether it is a new view.

        Raises:
            CameraError: it has another size than those before.
        """
        height, width = grey.shape
        if self._size is None:
            self._size = width, height
        if self._size != (width, height):
            was = "{} x {}".format(*self._size)
            raise CameraError(f"{name}: is {width} x {height} px, but others are {was}: give pictures of one size")
        found, corners = cv2.findChessboardCornersSB(
            grey, (self.columns, self.rows), flags=cv2.CALIB_CB_ACCURACY | cv2.CALIB_CB_NORMALIZE_IMAGE
        )
        if not found:
            self.blank += 1
            return False
        points = np.asarray(corners, dtype=np.float64).reshape(-1, 2)
        if any(_shift(points, other) < MOVED_MIN * math.hypot(width, height) for other in self._corners):
            self.similar += 1
            return False
        self._corners.append(points)
        self.names.append(name)
        return True

    def calibrate(self) -> "BoardCalibration":
        """Fit the camera.

        Raises:
            CameraError: too few or too similar views, or a fit that is not good enough.
        """
        count, of = len(self._corners), len(self._corners) + self.similar + self.blank
        if count < VIEWS_MIN or self._size is None:
            raise CameraError(
                f"{count} distinct views of a board with {self.columns} x {self.rows} inner corners in {of} pictures"
                f" ({self.blank} without it, {self.similar} like another): at least {VIEWS_MIN} are needed; move and"
                " tilt the board between pictures"
            )
        self._check_coverage(self._size)
        grid = np.zeros((self.columns * self.rows, 3), dtype=np.float32)
        grid[:, :2] = np.mgrid[: self.columns, : self.rows].T.reshape(-1, 2) * self.square
        pictures = [points.astype(np.float32).reshape(-1, 1, 2) for points in self._corners]
        _, inner, lens, turns, _, deviations, _, errors = cv2.calibrateCameraExtended(
            [grid] * count, pictures, self._size, np.eye(3), np.zeros(5), flags=cv2.CALIB_FIX_K3
        )
        fitted = np.asarray(inner, dtype=np.float64)
        each = np.asarray(errors, dtype=np.float64).reshape(-1)
        error = float(np.sqrt(np.mean(each**2)))
        _check_fit(fitted, np.asarray(deviations, dtype=np.float64).reshape(-1), turns, error)
        worst = int(np.argmax(each))
        k1, k2, p1, p2, k3 = (float(one) for one in np.asarray(lens).reshape(-1)[:5])
        width, height = self._size
        camera = CameraCalibration(
            width=width,
            height=height,
            focal=(float(fitted[0, 0]), float(fitted[1, 1])),
            centre=(float(fitted[0, 2]), float(fitted[1, 2])),
            distortion=(k1, k2, p1, p2, k3),
            error=error,
            views=count,
            date=datetime.now(UTC).date().isoformat(),
        )
        return BoardCalibration(camera, self.names[worst], float(each[worst]))

    def _check_coverage(self, size: tuple[int, int]) -> None:
        points = np.concatenate(self._corners)
        for axis, name in enumerate(("width", "height")):
            covered = float(np.ptp(points[:, axis])) / size[axis]
            if covered < COVERED_MIN:
                raise CameraError(
                    f"the board's corners cover {covered:.0%} of the picture's {name}: at least {COVERED_MIN:.0%} are"
                    " needed; move the board to the edges of the picture, and closer"
                )


@dataclass(frozen=True)
class BoardCalibration:
    """Calibration, and its worst view with the reprojection error there [px]."""

    camera: CameraCalibration
    worst: str
    worst_error: float


def _check_fit(inner: Array, deviations: Array, turns: Sequence[Any], error: float) -> None:
    """Refuse a fit that the views do not determine.

    Args:
        inner: camera matrix, shape (3, 3). deviations: of its parameters, as OpenCV orders them.
        turns: rotation vectors of the views. error: root mean square [px].
    """
    normals = [np.asarray(cv2.Rodrigues(turn)[0])[:, 2] for turn in turns]
    tilt = max(math.acos(float(np.clip(a @ b, -1.0, 1.0))) for a, b in itertools.combinations(normals, 2))
    if tilt < TILT_MIN:
        raise CameraError(
            f"all views of the board are alike: their tilts differ by {math.degrees(tilt):.0f} degrees, at least"
            f" {math.degrees(TILT_MIN):.0f} are needed; tilt it to all sides"
        )
    if error > ERROR_MAX or not math.isfinite(error):
        raise CameraError(
            f"the reprojection error is {error:.2f} px, above {ERROR_MAX:g}: is the board flat, its number of inner"
            " corners right, and are the pictures sharp?"
        )
    relative = float(max(deviations[0] / inner[0, 0], deviations[1] / inner[1, 1]))
    if not relative < FOCAL_DEVIATION_MAX:
        raise CameraError(
            f"the views determine the focal length to {relative:.1%} only, {FOCAL_DEVIATION_MAX:.0%} is needed: take"
            " more views, closer and more tilted"
        )


def _shift(one: Array, other: Array) -> float:
    """Mean distance of the corners of two views [px], whichever way round the board was found."""
    return min(float(np.mean(np.linalg.norm(one - way, axis=1))) for way in (other, other[::-1]))
