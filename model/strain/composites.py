"""Sums over all that lies beyond a section, in kernels: what wrenches, inertias and further turns add up to.

A section's modes move all beyond it as one rigid body, so that six by six matrices are all that the sections before it
need to know (the composite rigid bodies of R. Featherstone, Rigid Body Dynamics Algorithms, 2008, section 6.2).
"""

from typing import Any

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.products import BLOCK, HALF, Lines, add_products, padded
from tendond.model.numerics.simd import simd_load, simd_multiply_add, simd_store
from tendond.model.numerics.vectors import Matrix, Vector, add, cross, plus_outer, scale
from tendond.model.strain.kinematics import Shape, point_of
from tendond.model.strain.layout import Layout
from tendond.model.strain.spans import Spans
from tendond.model.strain.twists import load_six, load_three, store_three, times

ZERO = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
NONE = (0.0, 0.0, 0.0)


@inlined
def own_lanes(spans: Spans, s: int, b: int) -> Any:
    """Return 1 in those of eight lanes from b on that are a section's own modes, else 0."""
    row = len(spans.own) // len(spans.first) * s
    return simd_load(spans.own, row + b, BLOCK)


@inlined
def masked(vector: Any, own: Any) -> Any:
    """Return a vector in a section's own lanes, 0 in the others."""
    return vector[0] * own, vector[1] * own, vector[2] * own


@inlined
def own_six(shape: Shape, k: int, b: int, own: Any) -> Any:
    """Return the twist of a node by eight modes, 0 where they are not a section's own."""
    width = shape.spin.shape[1]
    return times(own, load_six(shape.twists, 6 * k * width + b, width))


@inlined
def add_wrench(rows: Any, at: int, stride: int, x: Vector, force: Any) -> None:
    """Add the wrench of a force at x to six rows."""
    store_three(rows, at, stride, add(load_three(rows, at, stride), cross(x, force)))
    below = at + 3 * stride
    store_three(rows, below, stride, add(load_three(rows, below, stride), force))


@inlined
def add_three(rows: Any, at: int, stride: int, vector: Any) -> None:
    """Add a vector to three rows."""
    store_three(rows, at, stride, add(load_three(rows, at, stride), vector))


@inlined
def add_moved(matrix: Any, of: int, six: Any, rows: Any, at: int, stride: int) -> None:
    """Add a six by six matrix, which begins at `of`, times a twist in eight lanes to six rows."""
    (x0, x1, x2), (x3, x4, x5) = six
    for row in range(6):
        here = of + 6 * row
        value = simd_multiply_add(matrix[here], x0, simd_load(rows, at + row * stride, BLOCK))
        value = simd_multiply_add(matrix[here + 1], x1, value)
        value = simd_multiply_add(matrix[here + 2], x2, value)
        value = simd_multiply_add(matrix[here + 3], x3, value)
        value = simd_multiply_add(matrix[here + 4], x4, value)
        simd_store(rows, at + row * stride, simd_multiply_add(matrix[here + 5], x5, value))


@inlined
def turned_push(moments: Matrix, force: Vector, part: Any) -> Any:
    """Return the moment by which forces beyond, moved by a twist `part`, push a further turn.

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
def write_turn(shape: Shape, k: int, b: int, own: Any, rows: Any, at: int, stride: int) -> None:
    """Write how eight of a section's modes turn the middle of an interval: three rows."""
    width = shape.spin.shape[1]
    turn, part = load_three(shape.twists, 6 * k * width + b, width), load_three(shape.parts, 6 * k * width + b, width)
    store_three(rows, at, stride, add(masked(turn, own), scale(0.5, part)))


@lean
def curvature_of_points(layout: Layout, shape: Shape, force: Any, room: Any, out: Any) -> None:
    """Add the sum over the mass points of force . d2x/dq dq, shape (n, n); forces are dead, world frame, shape (P, 3).

    A point that a distal strain moves by J is turned by every proximal strain's rotation: d2x = w x J. In their own
    interval both count by half, which is exact as the interval goes to 0. `room` holds `left`, `right` and `total` for
    `add_products`, and `pushes`, six rows of a section's modes.
    """
    n, width, stride, spans = len(out), padded(len(out)), shape.spin.shape[1], shape.spans
    left, right, total, pushes, narrow = room.left, room.right, room.total, room.pushes, spans.width[0]
    total[:] = 0.0
    f, moments = NONE, ZERO  # sums over the points beyond, of forces and of x force'
    j = len(layout.mass) - 1
    for s in range(len(spans.first) - 1, -1, -1):
        base, block, first, last, row = spans.node[s], spans.block[s], spans.first[s], spans.last[s], 0
        pushes[:] = 0.0
        for k in range(spans.node[s + 1] - 1, base - 1, -1):
            while j >= 0 and layout.place[j] == k + 1:
                pull = point_of(force, j)
                moments, f = plus_outer(moments, point_of(shape.point, j), pull), add(f, pull)
                j -= 1
            for b in range(block, last, HALF):
                x = turned_push(moments, f, load_six(shape.parts, 6 * k * stride + b, stride))
                store_three(left, row * narrow + b - block, narrow, x)
                if first > 0:
                    add_three(pushes, b - block, narrow, x)
                write_turn(shape, k, b, own_lanes(spans, s, b), right, row * narrow + b - block, narrow)
            row += 3
        of, whole = (first - block, last - block), Lines(total, block * width, width)
        add_products(
            Lines(left, 0, narrow),
            Lines(right, 0, narrow),
            row,
            of,
            (0, last - block),
            Lines(total, block * width + block, width),
        )
        add_products(Lines(pushes, 0, narrow), Lines(shape.twists, 6 * base * stride, stride), 3, of, (0, first), whole)
    for a in range(n):
        for b in range(a + 1):
            value = total[a * width + b] + total[b * width + a]
            out[a, b] += value
            if a != b:
                out[b, a] += value
