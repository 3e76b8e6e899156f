"""The round wire that sections amount to, for limits derived from a robot, where it has no short form."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from tendond.schemas.config.rod.section import BackboneSection
from tendond.schemas.config.rod.short_form import VARYING, stiffness_and_mass
from tendond.schemas.config.rod.table import Along, is_table, rows_of

PLACES = 20
"""Intervals of a section whose properties change."""


def mean_keys(sections: Sequence[BackboneSection]) -> dict[str, Any]:
    """Return radius, modulus and density of a wire with the mass of sections and disks, and their mean compliance."""
    compliance, mass, length, radius = 0.0, 0.0, 0.0, 0.0
    for section in sections:
        step = section.length / PLACES
        for index in range(PLACES):
            EI, _, EA, per_length = stiffness_and_mass(section, _values(section, (index + 0.5) * step))
            compliance += step / (0.5 * (EI[0] + EI[1]))
            mass += step * per_length
            radius += step * 2.0 * math.sqrt(EI[0] / EA)
        mass += section.disk_number * section.disk_mass
        length += section.length
    radius /= length
    area = math.pi * radius**2
    stiffness = length / compliance
    return {"radius": radius, "youngs_modulus": 4.0 * stiffness / (area * radius**2), "density": mass / length / area}


def _values(section: BackboneSection, s: float) -> dict[str, tuple[float, ...]]:
    found = {}
    for name, width in VARYING.items():
        value: Along | None = getattr(section, name)
        if value is not None:
            found[name] = _at(value, width, s)
    return found


def _at(value: Along, width: int, s: float) -> tuple[float, ...]:
    """Return the numbers at s, linear between rows, constant beyond them, shape (width,)."""
    if isinstance(value, float):
        return (value,) * width
    if not is_table(value):
        return tuple(one for one in value if not isinstance(one, tuple))
    rows = rows_of(value, width)
    for left, right in pairwise(rows):
        if s <= right[0]:
            part = min(max((s - left[0]) / (right[0] - left[0]), 0.0), 1.0)
            return tuple(a + part * (b - a) for a, b in zip(left[1:], right[1:], strict=True))
    return rows[-1][1:]
