"""A robot as arrays for the kernels: strain modes, intervals of the backbone, mass points, tendon quadrature."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.model.numerics.parked import park
from tendond.model.strain.describe.section import Section
from tendond.model.strain.robot import Robot, Tendon

Array = NDArray[np.float64]
Index = NDArray[np.int64]

INTERVALS = 8
"""Per section, for up to four bending modes; more modes take two each."""

TENDON_POINTS = 8
"""Gauss points per piece of a section between ends of tendons, and points of their routes."""

TENDON_POINTS_MIN = 3
"""The same, for a piece that is short beside its section."""

BENDING_X, BENDING_Y, TORSION, SHEAR_X, SHEAR_Y, STRETCH = 0, 1, 2, 3, 4, 5
"""Components of the strain (u, v) that have modes."""

TABLE_POINTS = 10
"""Gauss points per piece of a table: exact for a linear table and two polynomials of the eighth order."""

NEAR = 1e-9
"""As a part of the length: places that are closer are one."""


class Layout(NamedTuple):
    """The robot as the kernels take it; n modes, K intervals, interval k with the node k + 1 at its end, P mass points.

    Attributes:
        component, order: of each mode's strain, and its Legendre polynomial, shape (n,).
        first, last: modes that an interval's strain has, as a range, shape (K,).
        step: length of each interval [m], shape (K,).
        at1, at2: values of the modes at the interval's two Gauss points, shape (K, n).
        strain1, strain2: reference strain (u*, v*) there, shape (K, 6).
        place: node of each mass point, shape (P,); arm: from it, body frame [m], shape (P, 3); mass: [kg], shape (P,).
        drag: square-law drag at each mass point, body frame [kg/m], shape (P, 3).
        polar: polar inertia at each node [kg m^2], shape (K + 1,).
        stiffness, damping: of the modes, shape (n, n).
        tendon_at: values of the modes at the tendon points, shape (Q, n); tendon_strain: (u*, v*) there, shape (Q, 6).
        weight: of a point for each tendon [m], 0 beyond its end, shape (Q, m); route, slope: (x, y) and its derivative
            by s, shape (Q, m, 2).
        straight: path lengths in the reference shape [m], shape (m,).
        tendon_stiffness: [N/m], 0: none, shape (m,).
        gravity: world frame [m/s^2], shape (3,). base: row by row, shape (9,). origin: of the base [m], shape (3,).
    """

    component: Index
    order: Index
    first: Index
    last: Index
    step: Array
    at1: Array
    at2: Array
    strain1: Array
    strain2: Array
    place: Index
    arm: Array
    mass: Array
    drag: Array
    polar: Array
    stiffness: Array
    damping: Array
    tendon_at: Array
    tendon_strain: Array
    weight: Array
    route: Array
    slope: Array
    straight: Array
    tendon_stiffness: Array
    gravity: Array
    base: Array
    origin: Array


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


class ModeTable:
    """Which modes a robot has: component, order and section of each."""

    def __init__(self, robot: Robot) -> None:
        rows: list[tuple[int, int, int]] = []
        self.ranges: list[tuple[int, int]] = []
        for number, section in enumerate(robot.sections):
            first = len(rows)
            counts = (
                (BENDING_X, section.bending_modes), (BENDING_Y, section.bending_modes),
                (TORSION, section.torsion_modes), (SHEAR_X, section.shear_modes), (SHEAR_Y, section.shear_modes),
                (STRETCH, section.stretch_modes),
            )  # fmt: skip
            rows += [(component, order, number) for component, count in counts for order in range(count)]
            self.ranges.append((first, len(rows)))
        table = np.array(rows, dtype=np.int64)
        self.component, self.order = np.ascontiguousarray(table[:, 0]), np.ascontiguousarray(table[:, 1])
        self.count = len(rows)

    def values(self, section: int, part: float) -> Array:
        """Values of all modes at a place in a section, `part` of its length from its base; shape (n,)."""
        found = np.zeros(self.count)
        first, last = self.ranges[section]
        for mode in range(first, last):
            found[mode] = legendre.Legendre.basis(int(self.order[mode]))(2.0 * part - 1.0)
        return found


def section_at(robot: Robot, s: float) -> tuple[int, float]:
    """Return the section at an arc length of the backbone, and the arc length from that section's base [m].

    A place between two sections belongs to the one before it.
    """
    begin = 0.0
    for number, section in enumerate(robot.sections):
        if s <= begin + section.length * (1.0 + NEAR) or number == len(robot.sections) - 1:
            return number, min(max(s - begin, 0.0), section.length)
        begin += section.length
    raise AssertionError


def lay_out(robot: Robot) -> Layout:
    """Return the arrays of a robot.

    Raises:
        ParameterError: a body or a tendon that cannot be placed.
    """
    modes = ModeTable(robot)
    bodies = sorted(robot.bodies, key=lambda one: one.at)
    rows: dict[str, list[object]] = {name: [] for name in ("first", "last", "step", "at1", "at2", "strain1", "strain2")}
    points: list[tuple[int, Array, float, Array]] = []
    polar = [0.0]
    nodes = [0.0]
    offset = 1.0 / (2.0 * np.sqrt(3.0))
    begin = 0.0
    for number, section in enumerate(robot.sections):
        count = nodes_of(section)
        parts, _ = lobatto(count)
        placed = [body.at - begin for body in bodies if begin < body.at < begin + section.length]
        knots = section.inner_knots("curvature")
        more = [*placed, *(knots if len(knots) < count else ())]  # a finer table is smooth enough between the nodes
        inner = _distinct([*parts.tolist(), *(s / section.length for s in more)])
        for left, right in pairwise(inner):
            first, last = modes.ranges[number]
            middle, width = 0.5 * (left + right), right - left
            rows["first"].append(first)
            rows["last"].append(last)
            rows["step"].append(width * section.length)
            for at, strain, part in (
                ("at1", "strain1", middle - offset * width), ("at2", "strain2", middle + offset * width),
            ):  # fmt: skip
                rows[at].append(modes.values(number, part))
                rows[strain].append(np.array((*section.at("curvature", part * section.length), 0.0, 0.0, 1.0)))
            polar.append(0.0)
            nodes.append(begin + right * section.length)
        lumps = zip(parts, *(_lumped(section, name, parts) for name in LUMPED), strict=True)
        for part, mass, inertia, drag in lumps:
            node = int(np.argmin(np.abs(np.array(nodes) - (begin + part * section.length))))
            polar[node] += inertia[0]
            points.append((node, np.zeros(3), mass[0], drag))
        begin += section.length
    for index, body in enumerate(bodies):
        node = int(np.argmin(np.abs(np.array(nodes) - body.at)))
        if abs(nodes[node] - body.at) > 1e-9 * robot.length:
            raise ParameterError(f"body {index}: at = {body.at} has no node")
        points += [(node, arm, mass, np.zeros(3)) for mass, arm in body.points()]
    points = _merged([one for one in points if one[0] > 0])
    tendons = _tendons(robot, modes)
    stiffness, damping = _elasticity(robot, modes)
    layout = Layout(
        component=modes.component,
        order=modes.order,
        first=np.array(rows["first"], dtype=np.int64),
        last=np.array(rows["last"], dtype=np.int64),
        step=np.array(rows["step"], dtype=np.float64),
        **{name: np.array(rows[name], dtype=np.float64) for name in ("at1", "at2", "strain1", "strain2")},
        place=np.array([one[0] for one in points], dtype=np.int64),
        arm=np.array([one[1] for one in points], dtype=np.float64),
        mass=np.array([one[2] for one in points], dtype=np.float64),
        drag=np.array([one[3] for one in points], dtype=np.float64),
        polar=np.array(polar),
        stiffness=stiffness,
        damping=damping,
        **tendons,
        gravity=np.array(robot.gravity, dtype=np.float64),
        base=np.ascontiguousarray(robot.base, dtype=np.float64).reshape(9),
        origin=np.array(robot.origin, dtype=np.float64),
    )
    return park(layout)


LUMPED = ("mass_per_length", "polar_inertia", "drag")
"""Properties of a section that are lumped at its Lobatto points."""


def _distinct(parts: list[float]) -> list[float]:
    """Return the places in order, those that are nearly the same once."""
    found: list[float] = []
    for part in sorted(parts):
        if not found or part - found[-1] > NEAR:
            found.append(part)
    return found


def _pieces(section: Section, name: str, *more: float) -> list[tuple[float, float]]:
    """Gauss points s [m] and weights [m] over a section, with which a property's table is integrated exactly."""
    edges = _distinct([0.0, 1.0, *(s / section.length for s in (*section.inner_knots(name), *more))])
    points, weights = gauss(TABLE_POINTS)
    return [
        ((left + (right - left) * point) * section.length, (right - left) * weight * section.length)
        for left, right in pairwise(edges)
        for point, weight in zip(points, weights, strict=True)
    ]


def _lumped(section: Section, name: str, parts: Array) -> Array:
    """Integrals of a property times the Lagrange polynomials of the Lobatto points, shape (points, width).

    Total and moments along the section are exact; for a constant property they are the Lobatto weights. Where a steep
    table would make one of them negative, hats between the points keep total and first moment.
    """
    if name not in section.tables:
        return np.outer(lobatto(len(parts))[1] * section.length, section.at(name, 0.0))
    for shares in (_lagrange, _hats):
        found = np.zeros((len(parts), len(section.at(name, 0.0))))
        for s, weight in _pieces(section, name, *(parts * section.length if shares is _hats else ())):
            found += weight * np.outer(shares(parts, s / section.length), section.at(name, s))
        if np.all(found >= 0.0):
            break
    return found


def _lagrange(parts: Array, x: float) -> Array:
    apart = parts[:, None] - parts[None, :]
    return np.array([np.prod(np.delete(x - parts, i)) / np.prod(np.delete(apart[i], i)) for i in range(len(parts))])


def _hats(parts: Array, x: float) -> Array:
    return np.array([np.interp(x, parts, one) for one in np.eye(len(parts))])


def _merged(points: list[tuple[int, Array, float, Array]]) -> list[tuple[int, Array, float, Array]]:
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


MODULI = {
    BENDING_X: (("bending_stiffness", 0), ("bending_damping", 0)),
    BENDING_Y: (("bending_stiffness", 1), ("bending_damping", 1)),
    TORSION: (("torsion_stiffness", 0), ("bending_damping", 2)),
    SHEAR_X: (("shear_stiffness", 0), ("shear_damping", 0)),
    SHEAR_Y: (("shear_stiffness", 0), ("shear_damping", 0)),
    STRETCH: (("axial_stiffness", 0), ("axial_damping", 0)),
}
"""Stiffness and damping of each component of the strain: property of the section, and which of its values."""


def _elasticity(robot: Robot, modes: ModeTable) -> tuple[Array, Array]:
    """Stiffness and damping of the modes, shape (n, n): integrals of Phi' (stiffness, damping)(s) Phi.

    Diagonal in a uniform section; full in each component of one with tables.
    """
    found = np.zeros((2, modes.count, modes.count))
    for number, section in enumerate(robot.sections):
        for component, names in MODULI.items():
            chosen = [mode for mode in range(*modes.ranges[number]) if modes.component[mode] == component]
            for out, (name, index) in zip(found, names, strict=True):
                if name not in section.tables:
                    for mode in chosen:
                        norm = section.length / (2.0 * int(modes.order[mode]) + 1.0)
                        out[mode, mode] = section.at(name, 0.0)[index] * norm
                    continue
                for s, weight in _pieces(section, name):
                    values = modes.values(number, s / section.length)[chosen]
                    out[np.ix_(chosen, chosen)] += weight * section.at(name, s)[index] * np.outer(values, values)
    return found[0], found[1]


def _slope(tendon: Tendon, s: float, step: float) -> tuple[float, float]:
    """Derivative of a tendon's place in the cross-section by the arc length."""
    before, after = tendon.at(s - step), tendon.at(s + step)
    return (after[0] - before[0]) / (2.0 * step), (after[1] - before[1]) / (2.0 * step)


def _tendons(robot: Robot, modes: ModeTable) -> dict[str, Array]:
    """Quadrature of the tendons' paths."""
    count = len(robot.tendons)
    values: list[Array] = []
    strains: list[Array] = []
    weights: list[list[float]] = []
    routes: list[list[tuple[float, float]]] = []
    slopes: list[list[tuple[float, float]]] = []
    step = 1e-6 * robot.length
    begin = 0.0
    for number, section in enumerate(robot.sections):
        breaks = {0.0, section.length, *section.inner_knots("curvature")}
        for tendon in robot.tendons:
            breaks |= {s - begin for s in (tendon.end, *tendon.knots) if begin < s < begin + section.length}
        edges = [begin + part * section.length for part in _distinct([s / section.length for s in breaks])]
        for left, right in pairwise(edges):
            fine = max(TENDON_POINTS_MIN, round(TENDON_POINTS * min(1.0, 2.0 * (right - left) / section.length)))
            for part, weight in zip(*gauss(fine), strict=True):
                s = left + part * (right - left)
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
    arm = np.concatenate((route, np.zeros((*shape, 1))), axis=2)
    tangent = v + np.cross(u, arm) + np.concatenate((slope, np.zeros((*shape, 1))), axis=2)
    return {
        "tendon_at": np.array(values, dtype=np.float64),
        "tendon_strain": strain,
        "weight": weight,
        "route": route,
        "slope": slope,
        "straight": np.einsum("qm,qm->m", weight, np.linalg.norm(tangent, axis=2)),
        "tendon_stiffness": np.array([tendon.stiffness or 0.0 for tendon in robot.tendons], dtype=np.float64),
    }
