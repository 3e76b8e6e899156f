"""The mass matrix of a shape."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.products import BLOCK, HALF, Lines, add_products, padded
from tendond.model.numerics.simd import simd_load, simd_store
from tendond.model.numerics.vectors import Matrix, Vector, add, cross, dot, plus_diagonal, plus_outer, rotate, scale
from tendond.model.strain.composites import NONE, ZERO, add_three, add_wrench, masked, own_lanes, own_six
from tendond.model.strain.kinematics import Shape, point_of
from tendond.model.strain.layout import Layout
from tendond.model.strain.stepping.scratch import Scratch
from tendond.model.strain.twists import load_three, store_six, store_three

Array = NDArray[np.float64]


@inlined
def _moved(inertia: tuple[float, Vector, Matrix], twist: Any) -> Any:
    """Return the wrench that a rigid body's acceleration takes; mass, first and second moments about the origin."""
    mass, first, second = inertia
    u, v = twist
    return add(rotate(second, u), cross(first, v)), add(scale(mass, v), cross(u, first))


@lean
def find_mass(layout: Layout, shape: Shape, work: Scratch) -> None:
    """Write the upper half of the mass matrix of a shape to `work.mass`, section by section from the tip."""
    width, stride, spans = padded(len(layout.component)), shape.spin.shape[1], shape.spans
    left, right, total, pushes, narrow = work.left, work.right, work.mass, work.pushes, spans.width[0]
    total[:] = 0.0
    mass, first_moment, second = 0.0, NONE, ZERO  # of all sections beyond
    for s in range(len(spans.first) - 1, -1, -1):
        base, end, block, first, last = spans.node[s], spans.node[s + 1], spans.block[s], spans.first[s], spans.last[s]
        pushes[:] = 0.0
        row = 0
        for k in range(base + 1, end + 1):
            inertia = layout.polar[k]
            if inertia != 0.0:
                axis = (shape.rotation[k, 2], shape.rotation[k, 5], shape.rotation[k, 8])
                for b in range(block, last, HALF):
                    spin = simd_load(shape.spins, k * stride + b, BLOCK) * own_lanes(spans, s, b)
                    simd_store(left, row * narrow + b - block, inertia * spin)
                    simd_store(right, row * narrow + b - block, spin)
                    turned = inertia * spin
                    if first == 0:
                        continue
                    add_three(pushes, b - block, narrow, (turned * axis[0], turned * axis[1], turned * axis[2]))
                row += 1
        for j in range(spans.point[s], spans.point[s + 1]):
            m, x = layout.mass[j], point_of(shape.point, j)
            for b in range(block, last, HALF):
                moved = masked(load_three(shape.jacobians, 3 * j * stride + b, stride), own_lanes(spans, s, b))
                store_three(right, row * narrow + b - block, narrow, moved)
                moved = scale(m, moved)
                store_three(left, row * narrow + b - block, narrow, moved)
                if first > 0:
                    add_wrench(pushes, b - block, narrow, x, moved)
            row += 3
        if mass > 0.0:
            for b in range(block, last, HALF):
                twist = own_six(shape, end, b, own_lanes(spans, s, b))
                u, v = _moved((mass, first_moment, second), twist)
                store_six(left, row * narrow + b - block, narrow, twist)
                store_six(right, row * narrow + b - block, narrow, (u, v))
                add_three(pushes, b - block, narrow, u)
                add_three(pushes, 3 * narrow + b - block, narrow, v)
            row += 6
        add_products(
            Lines(left, 0, narrow), Lines(right, 0, narrow), row, (first - block, last - block), (0, last - block),
            Lines(total, block * width + block, width),
        )  # fmt: skip
        add_products(
            Lines(shape.twists, 6 * base * stride, stride), Lines(pushes, 0, narrow), 6, (0, first), (0, last - block),
            Lines(total, block, width),
        )  # fmt: skip
        for k in range(base + 1, end + 1):
            axis = (shape.rotation[k, 2], shape.rotation[k, 5], shape.rotation[k, 8])
            second = plus_outer(second, scale(layout.polar[k], axis), axis)
        for j in range(spans.point[s], spans.point[s + 1]):
            m, x = layout.mass[j], point_of(shape.point, j)
            mass, first_moment = mass + m, add(first_moment, scale(m, x))
            second = plus_diagonal(plus_outer(second, scale(-m, x), x), m * dot(x, x))


def mass_matrix(layout: Layout, shape: Shape, work: Scratch) -> Array:
    """Return the mass matrix of a shape, shape (n, n)."""
    n = len(layout.component)
    find_mass(layout, shape, work)
    upper = np.triu(work.mass.reshape(-1, padded.py_func(n))[:n, :n])
    return np.asarray(upper + np.triu(upper, 1).T)
