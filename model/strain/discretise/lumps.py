"""Mass, polar inertia and drag of a section, lumped at its Lobatto points."""

import numpy as np
from numpy.typing import NDArray

from tendond.model.strain.describe.section import Section
from tendond.model.strain.discretise.quadrature import lobatto, pieces

Array = NDArray[np.float64]

LUMPED = ("mass_per_length", "polar_inertia", "drag")
"""Properties of a section that are lumped at its Lobatto points."""


def lump(section: Section, name: str, parts: Array) -> Array:
    """Integrals of a property times the Lagrange polynomials of the Lobatto points, shape (points, width).

    Total and moments along the section are exact; for a constant property they are the Lobatto weights. Where a steep
    table would make one of them negative, hats between the points keep total and first moment.
    """
    if name not in section.tables:
        return np.outer(lobatto(len(parts))[1] * section.length, section.at(name, 0.0))
    for shares in (_lagrange, _hats):
        found = np.zeros((len(parts), len(section.at(name, 0.0))))
        for s, weight in pieces(section, name, *(parts * section.length if shares is _hats else ())):
            found += weight * np.outer(shares(parts, s / section.length), section.at(name, s))
        if np.all(found >= 0.0):
            break
    return found


def _lagrange(parts: Array, x: float) -> Array:
    apart = parts[:, None] - parts[None, :]
    return np.array([np.prod(np.delete(x - parts, i)) / np.prod(np.delete(apart[i], i)) for i in range(len(parts))])


def _hats(parts: Array, x: float) -> Array:
    return np.array([np.interp(x, parts, one) for one in np.eye(len(parts))])


def merge(points: list[tuple[int, Array, float, Array]]) -> list[tuple[int, Array, float, Array]]:
    """Join points at the same place of the same node: fewer of them for the kernels."""
    found: dict[tuple[int, bytes], tuple[int, Array, float, Array]] = {}
    for node, arm, mass, drag in points:
        name = (node, np.round(arm, 12).tobytes())
        if name in found:
            _, _, before, dragged = found[name]
            found[name] = (node, arm, before + mass, dragged + drag)
        else:
            found[name] = (node, arm, mass, drag)
    return sorted(found.values(), key=lambda one: one[0])
