"""Curves of trajectories in space: wanted places against the number of turns done."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from tendond.schemas.config.reference import ReferenceSection

Array = NDArray[np.float64]

Shape = Callable[[float], Array]
"""Number of turns done to the wanted place, shape (2,) or (3,); see `WorkspaceRest.compared`."""


def shape_of(section: ReferenceSection) -> Shape:
    """Return the curve that a section asks for, of a kind with turns: from 0 to `section.laps`."""
    center = np.array(section.center)
    if section.kind == "line":
        start, end = np.array(section.start), np.array(section.end)
        return lambda turns: start + 0.5 * (1.0 - math.cos(2.0 * math.pi * turns)) * (end - start)
    if section.kind == "figure_eight":
        return lambda turns: _offset(center, *_eight(section.radius, turns))
    first, last = section.radius, section.radius_end if section.kind == "helix" else section.radius

    def turn(turns: float) -> Array:
        radius = first + (last - first) * turns / section.laps
        return _offset(center, radius * math.cos(2.0 * math.pi * turns), radius * math.sin(2.0 * math.pi * turns))

    return turn


def sampled(section: ReferenceSection) -> tuple[CubicSpline, float]:
    """Return a spline through samples in space against time [s], at rest at both ends; and its end [s]."""
    table = np.array(section.samples)
    return CubicSpline(table[:, 0], table[:, 1:], bc_type="clamped"), float(table[-1, 0])


def _eight(half_width: float, turns: float) -> tuple[float, float]:
    """Gerono's lemniscate, which crosses itself in the middle."""
    angle = 2.0 * math.pi * turns
    return half_width * math.sin(angle), 0.5 * half_width * math.sin(2.0 * angle)


def _offset(center: Array, x: float, y: float) -> Array:
    place = center.copy()
    place[0] += x
    place[1] += y
    return place
