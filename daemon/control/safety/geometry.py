"""Signed distances of a body's points to surfaces, and their derivatives: for the safety filter and predictive laws.

A distance is above zero where the point may be. A half-space with unit normal n through a, a sphere about c of
radius r, kept out of or stayed in, and a body of radius b:

    d = n.(x - a) - b,    d = |x - c| - r - b,    d = r - |x - c|

A box is six half-spaces. Obstacles hold for all points of the body, the region for the tip, which is the last point.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.body.clearance import CENTER_MIN, SurfaceRows
from tendond.schemas.base import Vector3
from tendond.schemas.config.safety.section import SafetySection
from tendond.schemas.config.safety.shapes import TipRegion

Array = NDArray[np.float64]

REGION = "tip region"
"""Name of the region in messages."""


class Distances(NamedTuple):
    """Distances of a shape, or of several at once.

    Attributes:
        values: signed, above zero where allowed [m], shape (..., r).
        normals: derivatives by the row's point [-], unit vectors, shape (..., r, 3).
    """

    values: Array
    normals: Array


@dataclass(frozen=True)
class Surfaces:
    """Half-spaces and spheres, each with the points for which it holds: one row for each pair.

    Attributes:
        names: of the surfaces, for messages. surface: that of each row, shape (r,).
        rows: geometry of each row: levels n.a + b of half-spaces, r + b of spheres, r of those to stay in [m].
    """

    names: tuple[str, ...]
    surface: NDArray[np.intp]
    rows: SurfaceRows

    @property
    def point(self) -> NDArray[np.intp]:
        """Point of each row, shape (r,)."""
        return self.rows.point

    @property
    def count(self) -> int:
        """Number of rows, r."""
        return len(self.point)

    def measure(self, points: Array) -> Distances:
        """Return the distances of points [m], shape (..., p, 3)."""
        rows, at = self.rows, points[..., self.point, :]
        planes = len(rows.level)
        apart = at[..., planes:, :] - rows.center
        length = np.sqrt(np.einsum("...i,...i->...", apart, apart))
        flat = np.einsum("...i,...i->...", at[..., :planes, :], rows.normal) - rows.level
        values = np.concatenate((flat, rows.sign * (length - rows.level_sphere)), axis=-1)
        outward = (rows.sign / np.maximum(length, CENTER_MIN))[..., None] * apart
        normals = np.concatenate((np.broadcast_to(rows.normal, (*at.shape[:-2], planes, 3)), outward), axis=-2)
        return Distances(values, normals)

    def slopes(self, normals: Array, jacobians: Array) -> Array:
        """Return derivatives of distances by inputs, shape (..., r, m).

        Args:
            normals: of `Distances`, shape (..., r, 3). jacobians: of the points by inputs, shape (..., p, 3, m).
        """
        return np.asarray((normals[..., None, :] @ jacobians[..., self.point, :, :])[..., 0, :])


def surfaces_of(section: SafetySection, points: int, body_radius: float) -> Surfaces:
    """Return the surfaces of a configuration.

    Args:
        section: [safety]. points: number of the body's points, p; the last one is the tip.
        body_radius: of the body about its points [m]; the tip's region counts the tip's own point.
    """
    body, tip = range(points), range(points - 1, points)
    planes: list[tuple[str, Array, float, range]] = []
    spheres: list[tuple[str, Vector3, float, float, range]] = []
    for name, one in zip(section.labels, section.obstacle, strict=True):
        if one.center is not None and one.radius is not None:
            spheres.append((name, one.center, one.radius + body_radius, 1.0, body))
        elif one.point is not None and one.normal is not None:
            planes.append((name, *_plane(one.point, one.normal, body_radius), body))
    if section.tip_region is not None:
        if section.tip_region.center is not None and section.tip_region.radius is not None:
            spheres.append((REGION, section.tip_region.center, section.tip_region.radius, -1.0, tip))
        planes += [(REGION, *_plane(point, normal, 0.0), tip) for point, normal in _sides(section.tip_region)]
    held = [*((name, at) for name, _, _, at in planes), *((name, at) for name, _, _, _, at in spheres)]
    names = tuple(dict.fromkeys(name for name, _ in held))
    rows = [(names.index(name), point) for name, at in held for point in at]
    index = np.array(rows, dtype=np.intp).reshape(-1, 2)
    geometry = SurfaceRows(
        index[:, 1].copy(),
        np.array([normal for _, normal, _, at in planes for _ in at]).reshape(-1, 3),
        np.array([level for _, _, level, at in planes for _ in at]),
        np.array([center for _, center, _, _, at in spheres for _ in at]).reshape(-1, 3),
        np.array([radius for _, _, radius, _, at in spheres for _ in at]),
        np.array([sign for _, _, _, sign, at in spheres for _ in at]),
    )
    return Surfaces(names, index[:, 0], geometry)


def _plane(point: Vector3, normal: Vector3, body_radius: float) -> tuple[Array, float]:
    """Return the unit normal, and the level n.a + b [m]."""
    unit = np.array(normal) / math.hypot(*normal)
    return unit, float(unit @ np.array(point)) + body_radius


def _sides(region: TipRegion) -> list[tuple[Vector3, Vector3]]:
    """Return point and inward normal of each flat side."""
    if region.point is not None and region.normal is not None:
        return [(region.point, region.normal)]
    if region.low is None or region.high is None:
        return []
    sides: list[tuple[Vector3, Vector3]] = []
    for axis in range(3):
        unit = [0.0, 0.0, 0.0]
        unit[axis] = 1.0
        x, y, z = unit
        sides += [(region.low, (x, y, z)), (region.high, (-x, -y, -z))]
    return sides
