"""Twists and wrenches in kernels, as pairs of vectors, and the Magnus twist of an interval with its derivatives."""

import math
from typing import Any

from tendond.model.numerics.compile import inlined
from tendond.model.numerics.products import BLOCK
from tendond.model.numerics.simd import simd_load, simd_store
from tendond.model.numerics.vectors import Vector, add, cross, dot, scale
from tendond.model.strain.layout import Layout

Six = tuple[Vector, Vector]

COMMUTATOR = math.sqrt(3.0) / 12.0
"""Coefficient of the Magnus expansion with two Gauss points."""

SERIES = 4.0
"""Squared angle below which series take the place of quotients [rad^2]; they are exact to rounding there."""


@inlined
def polynomial(x: float) -> tuple[float, float, float, float, float, float, float, float]:
    """Return the coefficients of ad, ad^2, ad^3, ad^4 in the left Jacobian, then their derivatives by x = t^2.

    All follow from the tails r, t, s, d, c, b of the series of sine and cosine: b = (1 - cos t) / t^2 and
    c = (t - sin t) / t^3 with b' = d - c / 2, c' = -e, e = (d - 3 s) / 2.
    """
    if x < SERIES:
        t = (1.0 - x / 56.0 * (1.0 - x / 90.0 * (1.0 - x / 132.0 * (1.0 - x / 182.0 * (1.0 - x / 240.0 * (
            1.0 - x / 306.0 * (1.0 - x / 380.0 * (1.0 - x / 462.0)))))))) / 720.0  # fmt: skip
        r = (1.0 - x / 72.0 * (1.0 - x / 110.0 * (1.0 - x / 156.0 * (1.0 - x / 210.0 * (1.0 - x / 272.0 * (
            1.0 - x / 342.0 * (1.0 - x / 420.0 * (1.0 - x / 506.0)))))))) / 5040.0  # fmt: skip
        s, d = 1.0 / 120.0 - x * r, 1.0 / 24.0 - x * t
        c, b = 1.0 / 6.0 - x * s, 0.5 - x * d
    else:
        root = math.sqrt(x)
        b = (1.0 - math.cos(root)) / x
        c = (1.0 - math.sin(root) / root) / x
        s, d = (1.0 / 6.0 - c) / x, (0.5 - b) / x
        r, t = (1.0 / 120.0 - s) / x, (1.0 / 24.0 - d) / x
    e = 0.5 * (d - 3.0 * s)
    third = 0.5 * c - d
    b2 = 2.0 * t + 0.25 * d - 1.25 * s
    c2 = 3.75 * r + 0.25 * s - 1.75 * t
    return b + x * third, c + x * e, third, e, -x * b2, -x * c2, -b2, -c2


@inlined
def bracket(a: Six, b: Six) -> Six:
    """Return the Lie bracket of two twists."""
    return cross(a[0], b[0]), add(cross(a[0], b[1]), cross(a[1], b[0]))


@inlined
def plus(a: Six, b: Six) -> Six:
    """Return a + b."""
    return add(a[0], b[0]), add(a[1], b[1])


@inlined
def times(k: float, a: Six) -> Six:
    """Return k a."""
    return scale(k, a[0]), scale(k, a[1])


@inlined
def pair(a: Six, b: Six) -> float:
    """Return the product of a wrench and a twist."""
    value: float = dot(a[0], b[0]) + dot(a[1], b[1])
    return value


@inlined
def transposed(f: Six, w: Six) -> Six:
    """Return the wrench ad(f)' w: its product with a twist a is that of w with [f, a]."""
    return add(cross(w[0], f[0]), cross(w[1], f[1])), cross(w[1], f[0])


@inlined
def strain_rate(layout: Layout, w: Any, k: int, at: Any) -> Six:
    """Return the rate of the strain of interval k where the modes have the values `at`, for their rates w."""
    x0 = x1 = x2 = y0 = y1 = y2 = 0.0
    for d in range(layout.first[k], layout.last[k]):
        c, value = layout.component[d], at[k, d] * w[d]
        if c == 0:
            x0 += value
        elif c == 1:
            x1 += value
        elif c == 2:
            x2 += value
        elif c == 3:
            y0 += value
        elif c == 4:
            y1 += value
        else:
            y2 += value
    return (x0, x1, x2), (y0, y1, y2)


@inlined
def twist_at(twists: Any, k: int, d: int) -> Six:
    """Return the twist of node or interval k by the mode d."""
    return (twists[k, 0, d], twists[k, 1, d], twists[k, 2, d]), (twists[k, 3, d], twists[k, 4, d], twists[k, 5, d])


@inlined
def magnus(h: float, one: Six, two: Six) -> Six:
    """Return the Magnus twist of an interval from the strains at its Gauss points."""
    psi: Six = plus(times(0.5 * h, plus(one, two)), times(COMMUTATOR * h * h, bracket(one, two)))
    return psi


@inlined
def magnus_change(h: float, e1: Any, e2: Any, one: Any, two: Any) -> Any:
    """Return the derivative of the Magnus twist by the strains at the Gauss points, in the directions e1 and e2."""
    turned = plus(bracket(e1, two), bracket(one, e2))
    return plus(times(0.5 * h, plus(e1, e2)), times(COMMUTATOR * h * h, turned))


@inlined
def load_three(rows: Any, at: int, stride: int) -> Any:
    """Load eight lanes of a vector, whose rows are `stride` apart."""
    return simd_load(rows, at, BLOCK), simd_load(rows, at + stride, BLOCK), simd_load(rows, at + 2 * stride, BLOCK)


@inlined
def store_three(rows: Any, at: int, stride: int, vector: Any) -> None:
    """Store eight lanes of a vector."""
    simd_store(rows, at, vector[0])
    simd_store(rows, at + stride, vector[1])
    simd_store(rows, at + 2 * stride, vector[2])


@inlined
def load_six(rows: Any, at: int, stride: int) -> Any:
    """Load eight lanes of a twist, whose rows are `stride` apart."""
    return load_three(rows, at, stride), load_three(rows, at + 3 * stride, stride)


@inlined
def store_six(rows: Any, at: int, stride: int, six: Any) -> None:
    """Store eight lanes of a twist."""
    store_three(rows, at, stride, six[0])
    store_three(rows, at + 3 * stride, stride, six[1])
