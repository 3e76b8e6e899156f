"""Quadrature of the tendons' paths."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tendond.model.strain.discretise.modes import ModeTable
from tendond.model.strain.discretise.quadrature import NEAR, distinct, gauss
from tendond.model.strain.robot import Robot, Tendon

Array = NDArray[np.float64]
Index = NDArray[np.int64]

TENDON_POINTS = 8
"""Gauss points per piece of a section between ends of tendons, and points of their routes."""

TENDON_POINTS_MIN = 3
"""The same, for a piece that is short beside its section."""

STIFFNESS = 2e4
"""Stiffness of a tendon with friction for which none is given [N/m]: the shooting rod's."""


def _slope(tendon: Tendon, s: float, step: float) -> tuple[float, float]:
    """Derivative of a tendon's place in the cross-section by the arc length."""
    before, after = tendon.at(s - step), tendon.at(s + step)
    return (after[0] - before[0]) / (2.0 * step), (after[1] - before[1]) / (2.0 * step)


def route_tendons(robot: Robot, modes: ModeTable) -> tuple[dict[str, Array], Index]:
    """Return the quadrature of the tendons' paths, and `Layout.hole`."""
    count = len(robot.tendons)
    values: list[Array] = []
    strains: list[Array] = []
    weights: list[list[float]] = []
    routes: list[list[tuple[float, float]]] = []
    places: list[tuple[float, float]] = []
    slopes: list[list[tuple[float, float]]] = []
    step = 1e-6 * robot.length
    pierced = any(tendon.holes and tendon.friction > 0.0 for tendon in robot.tendons)
    begin = 0.0
    for number, section in enumerate(robot.sections):
        breaks = {0.0, section.length, *section.inner_knots("curvature")}
        for tendon in robot.tendons:
            held = tendon.holes if tendon.friction > 0.0 else ()
            breaks |= {s - begin for s in (tendon.end, *tendon.knots, *held) if begin < s < begin + section.length}
        edges = [begin + part * section.length for part in distinct([s / section.length for s in breaks])]
        for left, right in pairwise(edges):
            fine = max(TENDON_POINTS_MIN, round(TENDON_POINTS * min(1.0, 2.0 * (right - left) / section.length)))
            if pierced:
                fine += 1 - fine % 2  # a point in the middle of each span
            for part, weight in zip(*gauss(fine), strict=True):
                s = left + part * (right - left)
                places.append((s, begin))
                values.append(modes.values(number, (s - begin) / section.length))
                strains.append(np.array((*section.at("curvature", s - begin), 0.0, 0.0, 1.0)))
                passing = [tendon.end > 0.5 * (left + right) for tendon in robot.tendons]
                weights.append([weight * (right - left) if one else 0.0 for one in passing])
                routes.append([tendon.at(s) for tendon in robot.tendons])
                slopes.append([_slope(tendon, s, step) for tendon in robot.tendons])
        begin += section.length
    shape = (len(values), count)
    route = np.array(routes, dtype=np.float64).reshape(*shape, 2)
    slope = np.array(slopes, dtype=np.float64).reshape(*shape, 2)
    weight = np.array(weights, dtype=np.float64).reshape(shape)
    strain = np.array(strains, dtype=np.float64)
    u, v = strain[:, None, :3], strain[:, None, 3:]
    stiffness = np.array([tendon.stiffness or 0.0 for tendon in robot.tendons], dtype=np.float64)
    whole = np.where(stiffness > 0.0, stiffness, STIFFNESS) * [tendon.end for tendon in robot.tendons]
    arm = np.concatenate((route, np.zeros((*shape, 1))), axis=2)
    hole = np.empty(shape, dtype=np.int64)
    for index, tendon in enumerate(robot.tendons):
        hole[:, index] = _hole(tendon, [s for s, _ in places])
    tangent = v + np.cross(u, arm) + np.concatenate((slope, np.zeros((*shape, 1))), axis=2)
    return {
        "tendon_at": np.array(values, dtype=np.float64),
        "tendon_strain": strain,
        "weight": weight,
        "route": route,
        "slope": slope,
        "straight": np.einsum("qm,qm->m", weight, np.linalg.norm(tangent, axis=2)),
        "tendon_stiffness": stiffness,
        "friction": np.array([tendon.friction for tendon in robot.tendons], dtype=np.float64),
        "compliance": weight / whole,
        "reach": _reach(places),
    }, hole


def _hole(tendon: Tendon, places: list[float]) -> Index:
    """Return one tendon's column of `Layout.hole` for arc lengths of points [m].

    A straight span between two holes stands for the route between them: half of its bend counts to each.
    """
    own = np.arange(len(places))
    if not tendon.holes or tendon.friction == 0.0:
        return own
    turning = [0.0, *(s for s in tendon.holes if s < tendon.end * (1.0 - NEAR)), tendon.end]
    middles = 0.5 * (np.array(turning[1:]) + np.array(turning[:-1]))
    contact = np.searchsorted(places, turning)  # before the first point behind the hole
    between = 0.5 * (np.array(places) + np.concatenate(([0.0], places[:-1])))
    number = np.searchsorted(middles, between)
    number[contact[:-1]] = np.arange(len(turning) - 1)
    found = np.where(number < len(turning) - 1, contact[np.minimum(number, len(turning) - 2)], -1)
    return found.astype(np.int64)


def _reach(places: list[tuple[float, float]]) -> Array:
    """Return `Layout.reach` for arc lengths of points and of the beginnings of their sections [m]."""
    reach = np.zeros((len(places), 2))
    for index, ((before, other), (s, begin)) in enumerate(pairwise(places), 1):
        edge = begin if begin > other else 0.5 * (before + s)
        reach[index] = edge - before, s - edge
    reach[0, 0] = places[0][0] / (places[1][0] - places[0][0])
    return reach
