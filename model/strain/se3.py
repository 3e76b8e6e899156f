"""Rigid motions inside kernels: exponential of a twist and its left Jacobian, without cancellation at small angles.

Twists are (u, v): rotation first. Formulas after T. D. Barfoot, State Estimation for Robotics (2017), section 7.1.5;
the coupling block is written without products of matrices, by the identities of skew matrices F P F = -(f . r) F and
F F = f f' - f . f 1.
"""

import math

from tendond.model.numerics.compile import inlined
from tendond.model.numerics.vectors import Matrix, Vector

SMALL = 4.0
"""Squared angle below which series take the place of quotients [rad^2]; exact to rounding there."""


@inlined
def coefficients(x: float) -> tuple[float, float, float, float, float]:
    """Return sin t / t, (1 - cos t) / t^2, (t - sin t) / t^3 and the two further coefficients of Q, for t^2 = x."""
    if x < SMALL:
        d = (1.0 - x / 30.0 * (1.0 - x / 56.0 * (1.0 - x / 90.0 * (1.0 - x / 132.0 * (1.0 - x / 182.0 * (
            1.0 - x / 240.0 * (1.0 - x / 306.0 * (1.0 - x / 380.0 * (1.0 - x / 462.0))))))))) / 24.0  # fmt: skip
        s = (1.0 - x / 42.0 * (1.0 - x / 72.0 * (1.0 - x / 110.0 * (1.0 - x / 156.0 * (1.0 - x / 210.0 * (
            1.0 - x / 272.0 * (1.0 - x / 342.0 * (1.0 - x / 420.0 * (1.0 - x / 506.0))))))))) / 120.0  # fmt: skip
        c = 1.0 / 6.0 - x * s
        return 1.0 - x * c, 0.5 - x * d, c, d, 0.5 * (d - 3.0 * s)
    t = math.sqrt(x)
    sine, cosine = math.sin(t), math.cos(t)
    a, b = sine / t, (1.0 - cosine) / x
    c = (1.0 - a) / x
    return a, b, c, (0.5 - b) / x, 0.5 * (3.0 * c - b) / x


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
def _quadratic(f: Vector, one: float, skew: float, square: float) -> Matrix:
    """Return one 1 + skew F + square f f', row by row."""
    x, y, z = f
    sx, sy, sz = square * x, square * y, square * z
    return (
        one + sx * x, sx * y - skew * z, sx * z + skew * y,
        sx * y + skew * z, one + sy * y, sy * z - skew * x,
        sx * z - skew * y, sy * z + skew * x, one + sz * z,
    )  # fmt: skip


@inlined
def exponential(f: Vector, r: Vector) -> tuple[Matrix, Matrix, Matrix]:
    """Return rotation, left Jacobian and its coupling block of the twist (f, r), 3 x 3 each; J r is the translation."""
    x = f[0] * f[0] + f[1] * f[1] + f[2] * f[2]
    a, b, c, d, e = coefficients(x)
    rotation = _quadratic(f, 1.0 - b * x, a, b)
    jacobian = _quadratic(f, 1.0 - c * x, b, c)
    s = f[0] * r[0] + f[1] * r[1] + f[2] * r[2]
    # Q = b P + c (r f' + f r' - 2 s 1) + (2 d - c) s F - 2 e s (f f' - x 1)
    turned, square = (2.0 * d - c) * s, -2.0 * e * s
    k = (b * r[0] + turned * f[0], b * r[1] + turned * f[1], b * r[2] + turned * f[2])
    one = -2.0 * c * s - square * x
    gx, gy, gz = c * r[0] + square * f[0], c * r[1] + square * f[1], c * r[2] + square * f[2]
    hx, hy, hz = c * f[0], c * f[1], c * f[2]
    coupling = (
        one + gx * f[0] + hx * r[0], gx * f[1] + hx * r[1] - k[2], gx * f[2] + hx * r[2] + k[1],
        gy * f[0] + hy * r[0] + k[2], one + gy * f[1] + hy * r[1], gy * f[2] + hy * r[2] - k[0],
        gz * f[0] + hz * r[0] - k[1], gz * f[1] + hz * r[1] + k[0], one + gz * f[2] + hz * r[2],
    )  # fmt: skip
    return rotation, jacobian, coupling
