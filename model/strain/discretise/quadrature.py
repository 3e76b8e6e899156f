"""Quadrature along a section: Gauss and Lobatto points, and pieces between the rows of a table."""

from itertools import pairwise

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from tendond.model.strain.describe.section import Section

Array = NDArray[np.float64]

INTERVALS = 8
"""Intervals of a section with up to four bending modes; more modes take two each."""

TABLE_POINTS = 10
"""Gauss points per piece of a table: exact for a linear table and two polynomials of the eighth order."""

NEAR = 1e-9
"""Distance, as a part of the length, below which two places are one."""


def lobatto(count: int) -> tuple[Array, Array]:
    """Return `count` Gauss-Lobatto points on [0, 1] with their weights (Abramowitz and Stegun 25.4.32)."""
    polynomial = legendre.Legendre.basis(count - 1)
    inner = np.real(polynomial.deriv().roots())
    points = np.concatenate(([-1.0], np.sort(inner), [1.0]))
    weights = 2.0 / (count * (count - 1) * polynomial(points) ** 2)
    return 0.5 * (points + 1.0), 0.5 * weights


def gauss(count: int) -> tuple[Array, Array]:
    """Return `count` Gauss-Legendre points on [0, 1] with their weights."""
    points, weights = legendre.leggauss(count)
    return 0.5 * (points + 1.0), 0.5 * weights


def nodes_of(section: Section) -> int:
    """Return the number of Gauss-Lobatto points of a section, both ends included."""
    return INTERVALS + 2 * max(0, section.bending_modes - 4) + 1


def distinct(parts: list[float]) -> list[float]:
    """Return the places in order, those that are nearly the same once."""
    found: list[float] = []
    for part in sorted(parts):
        if not found or part - found[-1] > NEAR:
            found.append(part)
    return found


def pieces(section: Section, name: str, *more: float) -> list[tuple[float, float]]:
    """Gauss points s [m] and weights [m] over a section, with which a property's table is integrated exactly."""
    edges = distinct([0.0, 1.0, *(s / section.length for s in (*section.inner_knots(name), *more))])
    points, weights = gauss(TABLE_POINTS)
    return [
        ((left + (right - left) * point) * section.length, (right - left) * weight * section.length)
        for left, right in pairwise(edges)
        for point, weight in zip(points, weights, strict=True)
    ]
