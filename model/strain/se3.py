"""Rigid motions inside kernels: exponential of a twist and its left Jacobian, without cancellation at small angles.

Twists are (u, v): rotation first. Formulas after T. D. Barfoot, State Estimation for Robotics (2017), section 7.1.5.
"""

import math

from tendond.model.numerics.compile import inlined
from tendond.model.numerics.vectors import Matrix, Vector, add, cross, scale

SMALL = 0.25
"""[rad^2] Of the squared angle, below which series take the place of quotients."""


@inlined
def coefficients(x: float) -> tuple[float, float, float, float, float]:
    """Return sin t / t, (1 - cos t) / t^2, (t - sin t) / t^3 and the two further coefficients of Q, for t^2 = x."""
    if x < SMALL:
        return (
            1.0 - x / 6.0 * (1.0 - x / 20.0 * (1.0 - x / 42.0 * (1.0 - x / 72.0 * (1.0 - x / 110.0)))),
            0.5 * (1.0 - x / 12.0 * (1.0 - x / 30.0 * (1.0 - x / 56.0 * (1.0 - x / 90.0 * (1.0 - x / 132.0))))),
            (1.0 - x / 20.0 * (1.0 - x / 42.0 * (1.0 - x / 72.0 * (1.0 - x / 110.0 * (1.0 - x / 156.0))))) / 6.0,
            (1.0 - x / 30.0 * (1.0 - x / 56.0 * (1.0 - x / 90.0 * (1.0 - x / 132.0)))) / 24.0,
            1.0 / 120.0 - x / 2520.0 + x * x / 120960.0 - x * x * x / 9979200.0 + x * x * x * x / 1245404160.0,
        )
    t = math.sqrt(x)
    s, k = math.sin(t), math.cos(t)
    return (
        s / t,
        (1.0 - k) / x,
        (t - s) / (x * t),
        (0.5 * x + k - 1.0) / (x * x),
        0.5 * (2.0 * t - 3.0 * s + t * k) / (x * x * t),
    )


@inlined
def product(a: Matrix, b: Matrix) -> Matrix:
    """Return the product of two 3 x 3 matrices, row by row."""
    return (
        a[0] * b[0] + a[1] * b[3] + a[2] * b[6],
        a[0] * b[1] + a[1] * b[4] + a[2] * b[7],
        a[0] * b[2] + a[1] * b[5] + a[2] * b[8],
        a[3] * b[0] + a[4] * b[3] + a[5] * b[6],
        a[3] * b[1] + a[4] * b[4] + a[5] * b[7],
        a[3] * b[2] + a[4] * b[5] + a[5] * b[8],
        a[6] * b[0] + a[7] * b[3] + a[8] * b[6],
        a[6] * b[1] + a[7] * b[4] + a[8] * b[7],
        a[6] * b[2] + a[7] * b[5] + a[8] * b[8],
    )


@inlined
def from_columns(x: Vector, y: Vector, z: Vector) -> Matrix:
    """Return the matrix with these columns."""
    return x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]


@inlined
def _jacobian_column(f: Vector, b: float, c: float, a: Vector) -> Vector:
    fa = cross(f, a)
    column: Vector = add(a, add(scale(b, fa), scale(c, cross(f, fa))))
    return column


@inlined
def _coupling_column(f: Vector, r: Vector, c: float, d: float, e: float, a: Vector) -> Vector:
    """Column Q a of the left Jacobian's off-diagonal block, of rotation f and translation r."""
    ra, fa = cross(r, a), cross(f, a)
    fra, rfa, ffa = cross(f, ra), cross(r, fa), cross(f, fa)
    frfa, rffa, ffra = cross(f, rfa), cross(r, ffa), cross(f, fra)
    second = add(add(fra, rfa), frfa)
    third = add(add(ffra, rffa), scale(-3.0, frfa))
    fourth = add(cross(f, rffa), cross(f, frfa))
    column: Vector = add(add(scale(0.5, ra), scale(c, second)), add(scale(d, third), scale(e, fourth)))
    return column


@inlined
def exponential(f: Vector, r: Vector) -> tuple[Matrix, Matrix, Matrix]:
    """Return rotation, left Jacobian and its coupling block of the twist (f, r), 3 x 3 each; J r is the translation."""
    a, b, c, d, e = coefficients(f[0] * f[0] + f[1] * f[1] + f[2] * f[2])
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    rotation = from_columns(_jacobian_column(f, a, b, x), _jacobian_column(f, a, b, y), _jacobian_column(f, a, b, z))
    jacobian = from_columns(_jacobian_column(f, b, c, x), _jacobian_column(f, b, c, y), _jacobian_column(f, b, c, z))
    coupling = from_columns(
        _coupling_column(f, r, c, d, e, x), _coupling_column(f, r, c, d, e, y), _coupling_column(f, r, c, d, e, z)
    )
    return rotation, jacobian, coupling
