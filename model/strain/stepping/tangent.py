"""The derivative of the balance of a step by the strains after it, for Newton's method.

It is summed up section by section from the tip: see `composites`. With the twists X of a point's node, its moves are
A X, A = [-x, 1], x the cross product's matrix. A section's own modes take the sums over its points, those before it
the six by six sums (A0' D A1) / 2 and (A1' D A1) / 2 over all points beyond, in `apart`, D a point's inertia and drag.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.products import BLOCK, HALF, Lines, add_products, padded
from tendond.model.numerics.simd import simd_load, simd_store
from tendond.model.numerics.vectors import Matrix, Vector, add, cross, plus_outer, rotate, scale, sub
from tendond.model.strain.composites import (
    NONE,
    add_moved,
    add_three,
    add_wrench,
    curvature_of_points,
    masked,
    own_lanes,
    own_six,
)
from tendond.model.strain.friction.pulls import add_friction_curvature, add_friction_slopes
from tendond.model.strain.kinematics import axis_of, point_of
from tendond.model.strain.layout import Layout
from tendond.model.strain.stepping.own_turns import add_spins
from tendond.model.strain.stepping.scratch import Scratch
from tendond.model.strain.tendon_stiffness import add_tendon_stiffness
from tendond.model.strain.twists import load_three, pair, store_six, store_three

Array = NDArray[np.float64]

BEFORE, AFTER = 0, 36
"""Where the sums begin in `apart`: of wrenches on the shape before the step, and on that after it."""


@inlined
def _inertia_of(layout: Layout, work: Scratch, j: int, h: float) -> Matrix:
    """Return the derivative of a point's force by its move [N/m]."""
    one, two, k, factor = work.before, work.after, layout.place[j], 2.0 * layout.mass[j] / (h * h)
    d = (factor, 0.0, 0.0, 0.0, factor, 0.0, 0.0, 0.0, factor)
    for c in range(3):
        if layout.drag[j, c] != 0.0:
            r = scale(0.5, add(axis_of(one, k, c), axis_of(two, k, c)))
            x = sub(point_of(two.point, j), point_of(one.point, j))
            slope = 2.0 * layout.drag[j, c] * abs(r[0] * x[0] + r[1] * x[1] + r[2] * x[2]) / (h * h)
            d = plus_outer(d, scale(slope, r), r)
    return d


@inlined
def _add_apart(apart: Array, at: int, x: Vector, d: Matrix, y: Vector) -> None:
    """Add half of A' D A of a point at x in the shape of the wrenches, at y in that of the moves."""
    r0, r1, r2 = (d[0], d[1], d[2]), (d[3], d[4], d[5]), (d[6], d[7], d[8])
    _add_row(apart, at, sub(scale(x[1], r2), scale(x[2], r1)), y)
    _add_row(apart, at + 6, sub(scale(x[2], r0), scale(x[0], r2)), y)
    _add_row(apart, at + 12, sub(scale(x[0], r1), scale(x[1], r0)), y)
    _add_row(apart, at + 18, r0, y)
    _add_row(apart, at + 24, r1, y)
    _add_row(apart, at + 30, r2, y)


@inlined
def _add_row(apart: Array, at: int, row: Vector, y: Vector) -> None:
    """Add half of a row of a wrench by a point's move, times the point's move by a twist."""
    turned = cross(y, row)
    for c in range(3):
        apart[at + c] += 0.5 * turned[c]
        apart[at + 3 + c] += 0.5 * row[c]


@inlined
def _add_moved_back(apart: Array, at: int, six: Any, rows: Any, to: int, stride: int) -> None:
    """Add the transposed of a six by six matrix times a twist in eight lanes to six rows."""
    (x0, x1, x2), (x3, x4, x5) = six
    for row in range(6):
        here = at + row
        value = simd_load(rows, to + row * stride, BLOCK) + apart[here] * x0 + apart[here + 6] * x1
        value = value + apart[here + 12] * x2 + apart[here + 18] * x3 + apart[here + 24] * x4 + apart[here + 30] * x5
        simd_store(rows, to + row * stride, value)


@inlined
def _add_points(layout: Layout, h: float, work: Scratch) -> None:
    """Add what the mass points' inertia and drag do to `work.total`, and their work's share to `work.row`."""
    width, one, two, spans = padded(len(work.q1)), work.before, work.after, work.after.spans
    stride, narrow, left, right = two.spin.shape[1], spans.width[0], work.left, work.right
    apart, pushes, others, turns, total = work.apart, work.pushes, work.others, work.turns, work.total
    apart[:], total[:] = 0.0, 0.0
    force, moment = NONE, NONE  # of all points beyond, as their work's share has them
    for s in range(len(spans.first) - 1, -1, -1):
        base, end, block, first, last = spans.node[s], spans.node[s + 1], spans.block[s], spans.first[s], spans.last[s]
        pushes[:], others[:], turns[:] = 0.0, 0.0, 0.0
        row = 0
        more, spun = force, moment
        for j in range(spans.point[s], spans.point[s + 1]):
            d, x0, x1 = _inertia_of(layout, work, j, h), point_of(one.point, j), point_of(two.point, j)
            f = add(point_of(work.force, j), rotate(d, point_of(work.moved, j)))
            for b in range(block, last, HALF):
                own, at = own_lanes(spans, s, b), 3 * j * stride + b
                after = masked(load_three(two.jacobians, at, stride), own)
                mean = scale(0.5, add(after, masked(load_three(one.jacobians, at, stride), own)))
                left_part = rotate(d, mean)
                store_three(left, row * narrow + b - block, narrow, left_part)
                store_three(right, row * narrow + b - block, narrow, after)
                along = simd_load(work.share, b, BLOCK) + after[0] * f[0] + after[1] * f[1] + after[2] * f[2]
                simd_store(work.share, b, along)
                if first > 0:
                    push = rotate(d, scale(0.5, after))
                    add_wrench(pushes, b - block, narrow, x0, push)
                    add_wrench(others, b - block, narrow, x1, push)
                    add_wrench(turns, b - block, narrow, x1, left_part)
            more, spun = add(more, f), add(spun, cross(x1, f))
            row += 3
        if s + 1 < len(spans.first):
            for b in range(block, last, HALF):
                own, to = own_lanes(spans, s, b), b - block
                before, after = own_six(one, end, b, own), own_six(two, end, b, own)
                simd_store(work.share, b, simd_load(work.share, b, BLOCK) + pair(after, (moment, force)))
                for r in range(6):
                    simd_store(left, (row + r) * narrow + to, own * 0.0)
                _add_moved_back(apart, BEFORE, before, left, row * narrow + to, narrow)
                add_moved(apart, AFTER, after, left, row * narrow + to, narrow)
                store_six(right, row * narrow + to, narrow, after)
                if first > 0:
                    add_moved(apart, BEFORE, after, pushes, to, narrow)
                    add_moved(apart, AFTER, after, others, to, narrow)
                    add_three(turns, to, narrow, load_three(left, row * narrow + to, narrow))
                    add_three(turns, to + 3 * narrow, narrow, load_three(left, (row + 3) * narrow + to, narrow))
            row += 6
        force, moment = more, spun
        mine, by = (first - block, last - block), (0, last - block)
        add_products(
            Lines(left, 0, narrow), Lines(right, 0, narrow), row, mine, by, Lines(total, block * width + block, width)
        )  # fmt: skip
        if first > 0:
            at = 6 * base * stride
            here = Lines(total, block, width)
            add_products(Lines(one.twists, at, stride), Lines(pushes, 0, narrow), 6, (0, first), by, here)
            add_products(Lines(two.twists, at, stride), Lines(others, 0, narrow), 6, (0, first), by, here)
            add_products(
                Lines(turns, 0, narrow), Lines(two.twists, at, stride), 6, mine, (0, first),
                Lines(total, block * width, width),
            )  # fmt: skip
            for j in range(spans.point[s], spans.point[s + 1]):
                d, x1 = _inertia_of(layout, work, j, h), point_of(two.point, j)
                _add_apart(apart, BEFORE, point_of(one.point, j), d, x1)
                _add_apart(apart, AFTER, x1, d, x1)


@inlined
def _add_pulls(work: Scratch) -> None:
    """Add what the tendons' springs do to `work.total`, and the tendons' work's share to `work.share`."""
    n, width, left, right, row = len(work.q1), padded(len(work.q1)), work.left, work.right, 0
    for i in range(len(work.taut)):
        tension, slope = work.taut[i], work.slack[i]
        g0, g1 = work.paths_before.gradient, work.paths_after.gradient
        if tension != 0.0:
            force = slope * (work.paths_after.displacement[i] - work.paths_before.displacement[i]) + tension
            for b in range(n):
                work.share[b] -= force * g1[i, b]
        if slope != 0.0:
            for b in range(n):
                right[row * width + b], left[row * width + b] = g1[i, b], -0.5 * slope * (g0[i, b] + g1[i, b])
            for b in range(n, width):
                right[row * width + b] = left[row * width + b] = 0.0
            row += 1
    add_products(Lines(left, 0, width), Lines(right, 0, width), row, (0, n), (0, n), Lines(work.total, 0, width))


@lean
def find_matrix(layout: Layout, h: float, work: Scratch) -> None:
    """Write the derivative of the residual by q1 to `work.matrix`, after `find_residual` there."""
    n, width = len(work.q1), padded(len(work.q1))
    m, row, change, pull, total = work.hessian, work.share, work.change, work.pull, work.total
    m[:, :], row[:] = 0.0, 0.0  # `row`: derivative of what the balance lacks
    curvature_of_points(layout, work.after, work.force, work, m)
    if len(work.taut) > 0:
        add_tendon_stiffness(work.taut, work.paths_after, m)
    if len(work.grip.tendon) > 0:
        add_friction_curvature(work, m)
    _add_points(layout, h, work)
    _add_pulls(work)
    if len(work.grip.tendon) > 0:
        add_friction_slopes(layout, work)
    share, norm = work.unit[1], work.unit[2]
    for b in range(n):
        row[b] -= pull[b] + 2.0 * share * layout.stiffness[b, b] * change[b]
    for a in range(n):
        for b in range(n):
            m[a, b] = 0.5 * m[a, b] + total[a * width + b]
            row[b] -= change[a] * m[a, b]
    add_spins(layout, h, work)
    for a in range(n):
        along = layout.stiffness[a, a] * change[a] / norm
        for b in range(n):
            work.matrix[a * width + b] = m[a, b] + work.spun[a * width + b] + work.elastic[a, b] + along * row[b]
        work.matrix[a * width + a] += share * layout.stiffness[a, a]
