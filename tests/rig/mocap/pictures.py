"""Pictures of tags and boards with a known pose: rays of each pixel through the lens onto a plane."""

import functools

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tendond.drivers.apriltag.calibration import distortion, matrix
from tendond.drivers.apriltag.detector import draw
from tendond.drivers.mocap.geometry import Placement
from tendond.schemas.camera import CameraCalibration

Grey = NDArray[np.uint8]

CAMERA = CameraCalibration(
    width=640,
    height=480,
    focal=(700.0, 705.0),
    centre=(325.0, 236.0),
    distortion=(-0.12, 0.05, 0.001, -0.0005, 0.0),
    error=0.1,
    views=20,
)
FINE = 3
"""Rays per pixel, in each direction."""

TAG, TAG_MARGIN = 400, 80
"""Side of a tag's drawing without and width of its white margin [texels]."""


def facing(x: float, y: float, z: float, tilt: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Placement:
    """Place a printed plane in the camera's frame [m]: it faces the camera, then turned by a rotation vector [rad]."""
    return Placement(np.array([x, y, z]), Rotation.from_rotvec(tilt).as_matrix() @ np.diag([1.0, -1.0, -1.0]))


def tag(number: int, size: float, at: Placement) -> tuple[Grey, float, Placement]:
    """Plane with a tag of a size [m]: texture, texels per metre, placement of its centre."""
    texture = np.full((TAG + 2 * TAG_MARGIN,) * 2, 255, np.uint8)
    texture[TAG_MARGIN:-TAG_MARGIN, TAG_MARGIN:-TAG_MARGIN] = draw("36h11", number, TAG)
    return texture, TAG / size, at


def board(columns: int, rows: int, square: float, at: Placement) -> tuple[Grey, float, Placement]:
    """Plane with a chessboard of inner corners and squares of a size [m], with a white margin of a square."""
    side = 60
    cells = np.indices((rows + 1, columns + 1)).sum(axis=0) % 2
    texture = np.pad(np.kron(cells, np.full((side, side), 255)), side, constant_values=255).astype(np.uint8)
    return texture, side / square, at


def render(
    planes: list[tuple[Grey, float, Placement]],
    camera: CameraCalibration = CAMERA,
    *,
    noise: float = 2.0,
    seed: int = 0,
) -> Grey:
    """Render planes, the last one in front, with blur and noise [grey levels], shape (height, width)."""
    rays = _rays(camera)
    fine = np.full(rays.shape[:2], 140, np.uint8)
    for texture, scale, at in planes:
        normal = at.rotation[:, 2]
        depth = (normal @ at.position) / (rays @ normal)
        local = (rays * depth[..., None] - at.position) @ at.rotation
        u = (local[..., 0] * scale + 0.5 * (texture.shape[1] - 1)).astype(np.float32)
        v = (-local[..., 1] * scale + 0.5 * (texture.shape[0] - 1)).astype(np.float32)
        seen = cv2.remap(texture, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        on = (np.abs(local[..., 0]) * scale < 0.5 * texture.shape[1]) & (
            np.abs(local[..., 1]) * scale < 0.5 * texture.shape[0]
        )
        fine[on & (depth > 0.0)] = seen[on & (depth > 0.0)]
    coarse = cv2.resize(fine, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
    blurred = cv2.GaussianBlur(coarse, (0, 0), 0.6).astype(np.float64)
    return np.clip(blurred + np.random.default_rng(seed).normal(0.0, noise, blurred.shape), 0, 255).astype(np.uint8)


@functools.cache
def _rays(camera: CameraCalibration) -> NDArray[np.float64]:
    """Directions of the rays with z = 1, shape (FINE height, FINE width, 3)."""
    columns, rows = ((np.arange(n * FINE) + 0.5) / FINE - 0.5 for n in (camera.width, camera.height))
    pixels = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 1, 2)
    rays = np.asarray(cv2.undistortPoints(pixels, matrix(camera), distortion(camera))).reshape(-1, 2)
    ahead = np.column_stack([rays, np.ones(len(rays))])
    return np.asarray(ahead, dtype=np.float64).reshape(len(rows), len(columns), 3)
