"""Cells of the paths of tendons that rub, and the bends of these paths, for given strains, with their derivatives."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.vectors import Vector, add, cross, dot, scale
from tendond.model.strain.friction.grip import Cells, Grip
from tendond.model.strain.layout import Layout
from tendond.model.strain.tendons import Paths

Array = NDArray[np.float64]


@inlined
def _place(paths: Paths, j: int, i: int) -> Vector:
    """Return where tendon i runs at point j, from the backbone, body frame [m]."""
    at = 5 * j * len(paths.shortening) + i
    return paths.routes[at], paths.routes[at + len(paths.shortening)], 0.0


@inlined
def _tangent(paths: Paths, j: int, i: int) -> Vector:
    """Return the unit tangent of tendon i at point j, body frame."""
    to, width = 4 * j * len(paths.shortening) + i, len(paths.shortening)
    return paths.tangent[to], paths.tangent[to + width], paths.tangent[to + 2 * width]


@inlined
def _length(layout: Layout, paths: Paths, j: int, i: int) -> float:
    """Return the length of tendon i's path per length of the backbone at point j."""
    value: float = layout.weight[j, i] / paths.tangent[(4 * j + 3) * len(paths.shortening) + i]
    return value


@inlined
def _add_row(layout: Layout, paths: Paths, j: int, turned: Vector, moved: Vector, row: Any) -> None:
    """Add to a row the derivative by the modes of what depends on the strain at point j so."""
    for a in range(paths.first[j], paths.last[j]):
        c, value = layout.component[a], layout.tendon_at[j, a]
        if c < 3:
            row[a] += value * (turned[0] if c == 0 else turned[1] if c == 1 else turned[2])
        else:
            row[a] += value * (moved[0] if c == 3 else moved[1] if c == 4 else moved[2])


@lean
def find_cells(layout: Layout, paths: Paths, grip: Grip, cells: Cells) -> None:
    """Write the cells of a shape, after `find_paths` there."""
    for f in range(len(grip.tendon)):
        i = grip.tendon[f]
        for j in range(grip.number[f]):
            r, t, w = _place(paths, j, i), _tangent(paths, j, i), layout.weight[j, i]
            cells.shortening[f, j] = -w * _length(layout, paths, j, i)
            cells.gradient[f, j, :] = 0.0
            _add_row(layout, paths, j, scale(-w, cross(r, t)), scale(-w, t), cells.gradient[f, j])


@inlined
def _turned(rotation: Vector, t: Vector) -> Vector:
    """Return a vector turned by a rotation vector (Rodrigues)."""
    angle = math.sqrt(dot(rotation, rotation))
    if angle < 1e-12:
        small: Vector = add(t, cross(rotation, t))
        return small
    across = cross(rotation, t)
    one = math.sin(angle) / angle
    two = 2.0 * (math.sin(0.5 * angle) / angle) ** 2
    turned: Vector = add(t, add(scale(one, across), scale(two, cross(rotation, across))))
    return turned


@lean
def find_bends(layout: Layout, q: Array, paths: Paths, grip: Grip) -> None:
    """Write the bends of the paths at the contacts, after `find_paths` at the same strains q, shape (n,).

    The angle between the tangents at neighbouring points. Before the first point the path bends on as behind it. Where
    a tendon turns at holes only, the bend of half a span on either side counts to each of them.
    """
    points = len(grip.strain)
    for j in range(points):
        for c in range(3):
            grip.strain[j, c] = layout.tendon_strain[j, c]
        for a in range(paths.first[j], paths.last[j]):
            if layout.component[a] < 3:
                grip.strain[j, layout.component[a]] += layout.tendon_at[j, a] * q[a]
    for f in range(len(grip.tendon)):
        i = grip.tendon[f]
        mu = layout.friction[i]
        for j in range(1, grip.number[f]):
            left, right = layout.reach[j, 0], layout.reach[j, 1]
            before, after = grip.strain[j - 1], grip.strain[j]
            turn = (
                left * before[0] + right * after[0],
                left * before[1] + right * after[1],
                left * before[2] + right * after[2],
            )
            one, two = _tangent(paths, j - 1, i), _tangent(paths, j, i)
            here = _turned(turn, two)  # the tangent at point j, in the body frame of the point before
            across = cross(one, here)
            sine = math.sqrt(dot(across, across))
            grip.bend[f, j] = math.atan2(sine, dot(one, here))
            row = grip.turn[f, j]
            row[:] = 0.0
            if sine > 1e-14:
                axis = scale(1.0 / sine, across)
                first, last = cross(axis, one), cross(_turned(scale(-1.0, turn), axis), two)
                first = scale(-1.0 / _length(layout, paths, j - 1, i), first)
                last = scale(1.0 / _length(layout, paths, j, i), last)
                by_turn = add(scale(left, axis), cross(_place(paths, j - 1, i), first))
                _add_row(layout, paths, j - 1, by_turn, first, row)
                by_turn = add(scale(right, axis), cross(_place(paths, j, i), last))
                _add_row(layout, paths, j, by_turn, last, row)
        grip.bend[f, 0] = layout.reach[0, 0] * grip.bend[f, 1]
        for a in range(len(q)):
            grip.turn[f, 0, a] = layout.reach[0, 0] * grip.turn[f, 1, a]
        for j in range(grip.number[f]):
            to = layout.hole[j, i]
            if to != j:
                if to >= 0:
                    grip.bend[f, to] += grip.bend[f, j]
                    for a in range(len(q)):
                        grip.turn[f, to, a] += grip.turn[f, j, a]
                grip.bend[f, j] = 0.0
                grip.turn[f, j, :] = 0.0
        for j in range(grip.number[f]):
            grip.ratio[f, j] = math.exp(-mu * grip.bend[f, j])
