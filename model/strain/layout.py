"""A robot as arrays for the kernels: strain modes, intervals of the backbone, mass points, tendon quadrature."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.model.strain.robot import Robot, Tendon

Array = NDArray[np.float64]
Index = NDArray[np.int64]

INTERVALS = 8
"""Per section, for up to four bending modes; more modes take two each."""

TENDON_POINTS = 8
"""Gauss points per piece of a section between ends of tendons."""

BENDING_X, BENDING_Y, TORSION, STRETCH = 0, 1, 2, 5
"""Components of the strain (u, v) that have modes."""


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
        gravity: world frame [m/s^2], shape (3,). base: row by row, shape (9,).
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


class _Modes:
    """Which modes a robot has: component, order and section of each."""

    def __init__(self, robot: Robot) -> None:
        rows: list[tuple[int, int, int]] = []
        self.ranges: list[tuple[int, int]] = []
        for number, section in enumerate(robot.sections):
            first = len(rows)
            counts = (
                (BENDING_X, section.bending_modes), (BENDING_Y, section.bending_modes),
                (TORSION, section.torsion_modes), (STRETCH, section.stretch_modes),
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


def lay_out(robot: Robot) -> Layout:
    """Return the arrays of a robot.

    Raises:
        ParameterError: a body or a tendon that cannot be placed.
    """
    modes = _Modes(robot)
    bodies = sorted(robot.bodies, key=lambda one: one.at)
    rows: dict[str, list[object]] = {name: [] for name in ("first", "last", "step", "at1", "at2", "strain1", "strain2")}
    points: list[tuple[int, Array, float, Array]] = []
    polar = [0.0]
    nodes = [0.0]
    offset = 1.0 / (2.0 * np.sqrt(3.0))
    begin = 0.0
    for number, section in enumerate(robot.sections):
        count = INTERVALS + 2 * max(0, section.bending_modes - 4) + 1
        parts, weights = lobatto(count)
        placed = [body.at for body in bodies if begin < body.at < begin + section.length]
        inner = sorted({*parts.tolist(), *((at - begin) / section.length for at in placed)})
        reference = np.array((*section.curvature, 0.0, 0.0, 1.0))
        share = dict(zip(parts.tolist(), weights.tolist(), strict=True))
        for left, right in pairwise(inner):
            first, last = modes.ranges[number]
            middle, width = 0.5 * (left + right), right - left
            rows["first"].append(first)
            rows["last"].append(last)
            rows["step"].append(width * section.length)
            rows["at1"].append(modes.values(number, middle - offset * width))
            rows["at2"].append(modes.values(number, middle + offset * width))
            rows["strain1"].append(reference)
            rows["strain2"].append(reference)
            polar.append(0.0)
            nodes.append(begin + right * section.length)
        for part, weight in share.items():
            node = int(np.argmin(np.abs(np.array(nodes) - (begin + part * section.length))))
            amount = weight * section.length
            polar[node] += amount * section.polar_inertia
            points.append((node, np.zeros(3), amount * section.mass_per_length, amount * np.array(section.drag)))
        begin += section.length
    for index, body in enumerate(bodies):
        node = int(np.argmin(np.abs(np.array(nodes) - body.at)))
        if abs(nodes[node] - body.at) > 1e-9 * robot.length:
            raise ParameterError(f"body {index}: at = {body.at} has no node")
        points += [(node, arm, mass, np.zeros(3)) for mass, arm in body.points()]
    points = _merged([one for one in points if one[0] > 0])
    tendons = _tendons(robot, modes)
    stiffness, damping = _elasticity(robot, modes)
    return Layout(
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
    )


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


def _elasticity(robot: Robot, modes: _Modes) -> tuple[Array, Array]:
    """Stiffness and damping of the modes, shape (n, n): integrals of products of Legendre polynomials, diagonal."""
    stiffness, damping = np.zeros((2, modes.count, modes.count))
    for number, section in enumerate(robot.sections):
        moduli = {
            BENDING_X: (section.bending_stiffness[0], section.bending_damping[0]),
            BENDING_Y: (section.bending_stiffness[1], section.bending_damping[1]),
            TORSION: (section.torsion_stiffness, section.bending_damping[2]),
            STRETCH: (section.axial_stiffness, section.axial_damping),
        }
        for mode in range(*modes.ranges[number]):
            norm = section.length / (2.0 * int(modes.order[mode]) + 1.0)
            stiff, damped = moduli[int(modes.component[mode])]
            stiffness[mode, mode], damping[mode, mode] = stiff * norm, damped * norm
    return stiffness, damping


def _slope(tendon: Tendon, s: float, step: float) -> tuple[float, float]:
    """Derivative of a tendon's place in the cross-section by the arc length."""
    before, after = tendon.at(s - step), tendon.at(s + step)
    return (after[0] - before[0]) / (2.0 * step), (after[1] - before[1]) / (2.0 * step)


def _tendons(robot: Robot, modes: _Modes) -> dict[str, Array]:
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
        ends = {tendon.end for tendon in robot.tendons if begin < tendon.end < begin + section.length * (1.0 - 1e-9)}
        edges = [begin, *sorted(ends), begin + section.length]
        for left, right in pairwise(edges):
            for part, weight in zip(*gauss(TENDON_POINTS), strict=True):
                s = left + part * (right - left)
                values.append(modes.values(number, (s - begin) / section.length))
                strains.append(np.array((*section.curvature, 0.0, 0.0, 1.0)))
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
