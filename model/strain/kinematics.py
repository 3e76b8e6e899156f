"""Position of a robot for given strains, and how every point of it moves with them: one march from base to tip.

The strain is integrated over an interval by the fourth-order Magnus expansion on SE(3), whose derivative is exact for
it: the Jacobians are those of the discrete shape (A. Iserles, H. Z. Munthe-Kaas, S. P. Norsett, A. Zanna, "Lie-group
methods", Acta Numerica 9, 2000, section 5). Jacobians are kept as spatial twists, which add up along the backbone.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.parked import park
from tendond.model.numerics.products import BLOCK, HALF, add_products, padded
from tendond.model.numerics.simd import simd_load, simd_store
from tendond.model.numerics.vectors import Matrix, Vector, add, cross, plus_outer, rotate, scale
from tendond.model.strain.directions import DIRECTIONS, Directions, directions_of, vector_by_modes
from tendond.model.strain.layout import Layout
from tendond.model.strain.se3 import exponential, product
from tendond.model.strain.twists import load_six, load_three, magnus, magnus_change, plus, store_six, store_three

Array = NDArray[np.float64]


class Shape(NamedTuple):
    """A robot's shape, and its Jacobians; world frame. Modes come last: N numbers, n rounded up to a multiple of eight.

    Attributes:
        rotation: of each node, row by row, shape (K + 1, 9). position: [m], shape (K + 1, 3).
        twist: spatial twist of each node by each mode, shape (K + 1, 6, N); part: of each interval, shape (K, 6, N).
        point: mass points [m], shape (P, 3). jacobian: by the modes [m], shape (P, 3, N).
        spin: rotation about the own axis of each node by each mode, shape (K + 1, N).
        strain: at the Gauss points of each interval, shape (K, 2, 6). directions: of the strain.
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
        strain=np.zeros((intervals, 2, 6)), directions=directions_of(layout),
        **{name: rows[name].reshape(size) for name, size in shapes.items()},
        **{f"{name}s": row for name, row in rows.items()},
    )  # fmt: skip
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
def strain_of(shape: Shape, k: int, point: int) -> tuple[Vector, Vector]:
    """Return the strain (u, v) of an interval at one of its Gauss points."""
    s = shape.strain
    return (s[k, point, 0], s[k, point, 1], s[k, point, 2]), (s[k, point, 3], s[k, point, 4], s[k, point, 5])


@lean
def find_shape(layout: Layout, q: Array, shape: Shape) -> None:
    """Write the shape for the strains q, shape (n,), with all Jacobians."""
    width, strain, twists = shape.spin.shape[1], shape.strain, shape.twists
    directions, lanes = shape.directions, shape.directions.lanes
    for c in range(9):
        shape.rotation[0, c] = layout.base[c]
    for c in range(3):
        shape.position[0, c] = layout.origin[c]
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


@inlined
def turned_push(moments: Matrix, force: Vector, part: Any) -> Any:
    """Return the wrench by which forces beyond, turned with their points, push a further turn, for a twist `part`.

    `moments` is the sum of x force' over the points, row by row, `force` that of the forces.
    """
    (t0, t1, t2), v = part
    q = moments
    x, y, z = cross(v, force)
    return (
        x + q[1] * t1 + q[2] * t2 - (q[4] + q[8]) * t0,
        y + q[3] * t0 + q[5] * t2 - (q[0] + q[8]) * t1,
        z + q[6] * t0 + q[7] * t1 - (q[0] + q[4]) * t2,
    )


@inlined
def store_turns(shape: Shape, k: int, begin: int, last: int, right: Any, at: int, stride: int) -> None:
    """Write how every mode turns the middle of an interval, three rows; the interval's own modes are beyond `begin`."""
    width = shape.spin.shape[1]
    for b in range(0, last, HALF):
        turn = load_three(shape.twists, 6 * k * width + b, width)
        if b >= begin:
            turn = add(turn, scale(0.5, load_three(shape.parts, 6 * k * width + b, width)))
        store_three(right, at + b, stride, turn)


@lean
def curvature_of_points(
    layout: Layout, shape: Shape, force: Array, left: Array, right: Array, total: Array, out: Array
) -> None:
    """Add the sum over the mass points of force . d2x/dq dq, shape (n, n); forces are dead, world frame, shape (P, 3).

    A point that a distal strain moves by J is turned by every proximal strain's rotation: d2x = w x J. In their own
    interval both count by half, which is exact as the interval goes to 0. `left`, `right` and `total` are room for
    `add_products`.
    """
    n, width, own = len(layout.component), padded(len(layout.component)), shape.spin.shape[1]
    left[:], right[:], total[:] = 0.0, 0.0, 0.0
    f = (0.0, 0.0, 0.0)
    moments = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # sum of x force' over the points beyond
    j = len(layout.mass) - 1
    row = start = 0
    for k in range(len(layout.step) - 1, -1, -1):
        while j >= 0 and layout.place[j] == k + 1:
            pull = force[j, 0], force[j, 1], force[j, 2]
            moments = plus_outer(moments, (shape.point[j, 0], shape.point[j, 1], shape.point[j, 2]), pull)
            f = add(f, pull)
            j -= 1
        first, last, begin = layout.first[k], layout.last[k], shape.directions.begin[k]
        for b in range(begin, last, HALF):
            x = turned_push(moments, f, load_six(shape.parts, 6 * k * own + b, own))
            store_three(left, row * width + b, width, x)
        store_turns(shape, k, begin, last, right, row * width, width)
        row += 3
        if k == 0 or layout.first[k - 1] != first:
            add_products(left, right, width, (start, row), (first, last), (0, last), total)
            start = row
    for a in range(n):
        for b in range(a + 1):
            value = total[a * width + b] + total[b * width + a]
            out[a, b] += value
            if a != b:
                out[b, a] += value
