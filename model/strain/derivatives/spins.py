"""Derivative of the nodes' rotation rates about their own axes by the strains."""

from typing import Any

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.products import BLOCK, HALF
from tendond.model.numerics.simd import simd_load, simd_store
from tendond.model.numerics.vectors import Vector, add, cross, dot, rotate, scale
from tendond.model.strain.directions import DIRECTIONS, vector_by_modes
from tendond.model.strain.kinematics import Shape, rotation_of, strain_of
from tendond.model.strain.layout import Layout
from tendond.model.strain.second_derivatives.bends import Bends
from tendond.model.strain.twists import COMMUTATOR, load_six, polynomial, strain_rate


@inlined
def _left(f: Vector, b: float, c: float, a: Any) -> Any:
    """Return the left Jacobian of the rotation f, of coefficients b and c, times a."""
    fa = cross(f, a)
    return add(a, add(scale(b, fa), scale(c, cross(f, fa))))


@lean
def find_spins(layout: Layout, w: Any, shape: Shape, room: Bends, turn: Any, out: Any) -> None:
    """Write the derivative of each node's rotation rate about its own axis by the strains, at fixed rates w, rows of N.

    `turn` is room for the derivative of the nodes' rotation rates, three rows; N as in `Shape`.
    """
    own, width = room.change, shape.spin.shape[1]
    rate = (0.0, 0.0, 0.0)
    turn[:] = 0.0
    for k in range(len(layout.step)):
        last, h = layout.last[k], layout.step[k]
        one, two = strain_of(shape, k, 0)[0], strain_of(shape, k, 1)[0]
        moved1, _ = strain_rate(layout, w, k, layout.at1)
        moved2, _ = strain_rate(layout, w, k, layout.at2)
        half, magnus = 0.5 * h, COMMUTATOR * h * h
        f = add(scale(half, add(one, two)), scale(magnus, cross(one, two)))
        x = dot(f, f)
        c1, c2, c3, c4, _, _, _, _ = polynomial(x)
        b, c = c1 - x * c3, c2 - x * c4
        a = add(scale(half, add(moved1, moved2)), scale(magnus, add(cross(moved1, two), cross(one, moved2))))
        fa = cross(f, a)
        squared = add(scale(-2.0 * c3, fa), scale(-2.0 * c4, cross(f, fa)))
        r = rotation_of(shape, k)
        for group in range(room.directions.groups[k]):
            at = room.directions.base[k] + group * HALF
            e1, _ = load_six(room.directions.unit, at, DIRECTIONS)
            e2, _ = load_six(room.directions.unit, at + 6 * DIRECTIONS, DIRECTIONS)
            by = add(scale(half, add(e1, e2)), scale(magnus, add(cross(e1, two), cross(one, e2))))
            ba = cross(by, a)
            y = add(scale(b, ba), scale(c, add(cross(by, fa), cross(f, ba))))
            both = scale(magnus, add(cross(e1, moved2), cross(moved1, e2)))
            y = rotate(r, add(add(y, scale(dot(f, by), squared)), _left(f, b, c, both)))
            simd_store(own, group * HALF, y[0])
            simd_store(own, DIRECTIONS + group * HALF, y[1])
            simd_store(own, 2 * DIRECTIONS + group * HALF, y[2])
        part = rotate(r, _left(f, b, c, a))
        rate = add(rate, part)
        z = (shape.rotation[k + 1, 2], shape.rotation[k + 1, 5], shape.rotation[k + 1, 8])
        across = cross(z, rate)
        for b in range(0, last, HALF):
            before = load_six(shape.twists, 6 * k * width + b, width)[0]
            after = load_six(shape.twists, 6 * (k + 1) * width + b, width)[0]
            turned = (
                simd_load(turn, b, BLOCK), simd_load(turn, width + b, BLOCK), simd_load(turn, 2 * width + b, BLOCK)
            )  # fmt: skip
            turned = add(turned, cross(before, part))
            if b >= room.directions.begin[k]:
                turned = add(turned, vector_by_modes(room.directions, k, own, 0, b))
            simd_store(turn, b, turned[0])
            simd_store(turn, width + b, turned[1])
            simd_store(turn, 2 * width + b, turned[2])
            simd_store(out, (k + 1) * width + b, dot(after, across) + dot(z, turned))
