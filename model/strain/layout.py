"""A robot as arrays for the kernels: strain modes, intervals of the backbone, mass points, tendon quadrature."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.model.numerics.parked import park
from tendond.model.strain.discretise.elasticity import find_elasticity
from tendond.model.strain.discretise.lumps import LUMPED, lump, merge
from tendond.model.strain.discretise.modes import ModeTable
from tendond.model.strain.discretise.quadrature import distinct, lobatto, nodes_of
from tendond.model.strain.discretise.routes import route_tendons
from tendond.model.strain.robot import Robot

Array = NDArray[np.float64]

Index = NDArray[np.int64]


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
        tendon_stiffness: [N/m], 0: none, shape (m,). friction: coefficients of the tendons on their guides, shape (m,).
        compliance: of the tendon at a point, with its weight [m/N], shape (Q, m).
        reach: of the section before a point from the point before it, and of its own, shape (Q, 2) [m]; the first has
            its distance from the base, as a part of that to the second point, instead.
        hole: contact to which the bend at each contact counts, for each tendon: itself, or that at a hole; -1: that
            where the tendon is fixed, at which nothing slides; shape (Q, m).
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
    friction: Array
    compliance: Array
    reach: Array
    hole: Index
    gravity: Array
    base: Array
    origin: Array


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
        inner = distinct([*parts.tolist(), *(s / section.length for s in more)])
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
        lumps = zip(parts, *(lump(section, name, parts) for name in LUMPED), strict=True)
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
    points = merge([one for one in points if one[0] > 0])
    tendons, hole = route_tendons(robot, modes)
    stiffness, damping = find_elasticity(robot, modes)
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
        hole=hole,
        gravity=np.array(robot.gravity, dtype=np.float64),
        base=np.ascontiguousarray(robot.base, dtype=np.float64).reshape(9),
        origin=np.array(robot.origin, dtype=np.float64),
    )
    return park(layout)
