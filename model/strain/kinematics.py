"""Position of a robot for given strains, and how every point of it moves with them: one march from base to tip.

The strain is integrated over an interval by the fourth-order Magnus expansion on SE(3), whose derivative is exact for
it: the Jacobians are those of the discrete shape (A. Iserles, H. Z. Munthe-Kaas, S. P. Norsett, A. Zanna, "Lie-group
methods", Acta Numerica 9, 2000, section 5). Jacobians are kept as spatial twists, which add up along the backbone.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.parked import park
from tendond.model.numerics.products import BLOCK, HALF
from tendond.model.numerics.simd import simd_load, simd_store
from tendond.model.numerics.vectors import Matrix, Vector, add, cross, rotate
from tendond.model.strain.directions import DIRECTIONS, Directions, directions_of, vector_by_modes
from tendond.model.strain.layout import Layout
from tendond.model.strain.se3 import exponential, product
from tendond.model.strain.spans import Spans, spans_of
from tendond.model.strain.twists import load_six, load_three, magnus, magnus_change, plus, store_six, store_three

Array = NDArray[np.float64]


class Shape(NamedTuple):
    """A robot's shape, and its Jacobians; world frame. Modes come last: N numbers, n rounded up to a multiple of eight.

    Attributes:
        rotation: of each node, row by row, shape (K + 1, 9). position: [m], shape (K + 1, 3).
        twist: spatial twist of each node by each mode, shape (K + 1, 6, N); part: of each interval, shape (K, 6, N).
        point: mass points [m], shape (P, 3). jacobian: by the modes [m], shape (P, 3, N).
        spin: rotation about the own axis of each node by each mode, shape (K + 1, N).
        strain: at the Gauss points of each interval, shape (K, 2, 6). directions: of the strain. spans: sections.
        twists, parts, jacobians, spins: the same numbers in a row.
    """

    rotation: Array
    position: Array
    twist: Array
    part: Array
    point: Array
    jacobian: Array
    spin: Array
    strain: Array
    directions: Directions
    spans: Spans
    twists: Array
    parts: Array
    jacobians: Array
    spins: Array


def empty_shape(layout: Layout) -> Shape:
    """Return arrays for a shape of this robot."""
    intervals, n = layout.at1.shape
    points, width = len(layout.mass), -(-n // HALF) * HALF
    shapes = {
        "twist": (intervals + 1, 6, width),
        "part": (intervals, 6, width),
        "jacobian": (points, 3, width),
        "spin": (intervals + 1, width),
    }
    rows = {name: aligned(math.prod(size)) for name, size in shapes.items()}
    shape = Shape(
        rotation=np.zeros((intervals + 1, 9)), position=np.zeros((intervals + 1, 3)), point=np.zeros((points, 3)),
        strain=np.zeros((intervals, 2, 6)), directions=directions_of(layout), spans=spans_of(layout),
        **{name: rows[name].reshape(size) for name, size in shapes.items()},
        **{f"{name}s": row for name, row in rows.items()},
    )  # fmt: skip
    shape.rotation[0], shape.position[0] = layout.base, layout.origin
    return park(shape)


def aligned(size: int) -> Array:
    """Return zeros that begin where a line of the processor's cache does, so that eight of them lie in one."""
    found = np.zeros(size + HALF)
    skipped = -found.ctypes.data // found.itemsize % HALF
    return found[skipped : skipped + size]


@inlined
def rotation_of(shape: Shape, k: int) -> Matrix:
    """Return the rotation of the node k, row by row."""
    r = shape.rotation
    return r[k, 0], r[k, 1], r[k, 2], r[k, 3], r[k, 4], r[k, 5], r[k, 6], r[k, 7], r[k, 8]


@inlined
def position_of(shape: Shape, k: int) -> Vector:
    """Return the position of the node k."""
    return shape.position[k, 0], shape.position[k, 1], shape.position[k, 2]


@inlined
def point_of(values: Array, j: int) -> Vector:
    """Return the vector of a mass point, of those of all."""
    return values[j, 0], values[j, 1], values[j, 2]


@inlined
def axis_of(shape: Shape, k: int, c: int) -> Vector:
    """Return an axis of the node k's frame."""
    return shape.rotation[k, c], shape.rotation[k, 3 + c], shape.rotation[k, 6 + c]


@inlined
def strain_of(shape: Shape, k: int, point: int) -> tuple[Vector, Vector]:
    """Return the strain (u, v) of an interval at one of its Gauss points."""
    s = shape.strain
    return (s[k, point, 0], s[k, point, 1], s[k, point, 2]), (s[k, point, 3], s[k, point, 4], s[k, point, 5])


@lean
def find_shape(layout: Layout, q: Array, shape: Shape) -> None:
    """Write the shape for the strains q, shape (n,), with all Jacobians; the first node holds where the base is."""
    width, strain, twists = shape.spin.shape[1], shape.strain, shape.twists
    directions, lanes = shape.directions, shape.directions.lanes
    for k in range(len(layout.step)):
        first, last = layout.first[k], layout.last[k]
        for c in range(6):
            strain[k, 0, c], strain[k, 1, c] = layout.strain1[k, c], layout.strain2[k, c]
        for d in range(first, last):
            c = layout.component[d]
            strain[k, 0, c] += layout.at1[k, d] * q[d]
            strain[k, 1, c] += layout.at2[k, d] * q[d]
        h, one, two = layout.step[k], strain_of(shape, k, 0), strain_of(shape, k, 1)
        f, r = magnus(h, one, two)
        turn, jacobian, coupling = exponential(f, r)
        before, place = rotation_of(shape, k), position_of(shape, k)
        after = product(before, turn)
        step = rotate(before, rotate(jacobian, r))
        for c in range(9):
            shape.rotation[k + 1, c] = after[c]
        for c in range(3):
            shape.position[k + 1, c] = place[c] + step[c]
        rj, rq = product(before, jacobian), product(before, coupling)
        for group in range(directions.groups[k]):
            unit, at = directions.unit, directions.base[k] + group * HALF
            e1, e2 = load_six(unit, at, DIRECTIONS), load_six(unit, at + 6 * DIRECTIONS, DIRECTIONS)
            au, av = magnus_change(h, e1, e2, one, two)
            ou = rotate(rj, au)
            ov = add(add(rotate(rq, au), rotate(rj, av)), cross(place, ou))
            store_six(lanes, group * HALF, DIRECTIONS, (ou, ov))
        begin = directions.begin[k]
        for i in range(6):
            near, far = (6 * k + i) * width, (6 * (k + 1) + i) * width
            for b in range(0, begin, HALF):
                simd_store(twists, far + b, simd_load(twists, near + b, BLOCK))
        near, far = 6 * k * width, 6 * (k + 1) * width
        for b in range(begin, last, HALF):
            own = vector_by_modes(directions, k, lanes, 0, b), vector_by_modes(directions, k, lanes, 3, b)
            store_six(shape.parts, near + b, width, own)
            store_six(twists, far + b, width, plus(load_six(twists, near + b, width), own))
        for b in range(0, last, HALF):
            u = load_three(twists, far + b, width)
            simd_store(shape.spins, (k + 1) * width + b, u[0] * after[2] + u[1] * after[5] + u[2] * after[8])
    for j in range(len(layout.mass)):
        k = layout.place[j]
        arm = (layout.arm[j, 0], layout.arm[j, 1], layout.arm[j, 2])
        x = add(position_of(shape, k), rotate(rotation_of(shape, k), arm))
        for i in range(3):
            shape.point[j, i] = x[i]
        at, to = 6 * k * width, 3 * j * width
        for b in range(0, layout.last[k - 1], HALF):
            u, v = load_six(twists, at + b, width)
            store_three(shape.jacobians, to + b, width, add(cross(u, x), v))
