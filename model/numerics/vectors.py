"""Vectors in space as tuples of three numbers, for use inside kernels: they live in registers, not in memory."""

from tendond.model.numerics.compile import inlined

Vector = tuple[float, float, float]
Matrix = tuple[float, float, float, float, float, float, float, float, float]
"""Shape (3, 3), row by row."""


@inlined
def add(a: Vector, b: Vector) -> Vector:
    """a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inlined
def sub(a: Vector, b: Vector) -> Vector:
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inlined
def scale(factor: float, a: Vector) -> Vector:
    """factor * a."""
    return factor * a[0], factor * a[1], factor * a[2]


@inlined
def times(a: Vector, b: Vector) -> Vector:
    """Component by component; `times(k, a)` is a diagonal matrix times a vector."""
    return a[0] * b[0], a[1] * b[1], a[2] * b[2]


@inlined
def dot(a: Vector, b: Vector) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def cross(a: Vector, b: Vector) -> Vector:
    """a x b, that is hat(a) b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined
def rotate(rotation: tuple[float, ...], a: Vector) -> Vector:
    """R a: body to world; R row by row, nine floats."""
    r = rotation
    return (
        r[0] * a[0] + r[1] * a[1] + r[2] * a[2],
        r[3] * a[0] + r[4] * a[1] + r[5] * a[2],
        r[6] * a[0] + r[7] * a[1] + r[8] * a[2],
    )


@inlined
def rotate_back(rotation: tuple[float, ...], a: Vector) -> Vector:
    """R' a: world to body."""
    r = rotation
    return (
        r[0] * a[0] + r[3] * a[1] + r[6] * a[2],
        r[1] * a[0] + r[4] * a[1] + r[7] * a[2],
        r[2] * a[0] + r[5] * a[1] + r[8] * a[2],
    )


@inlined
def drag(coefficient: Vector, a: Vector) -> Vector:
    """Square-law drag per component: C a |a|."""
    return coefficient[0] * a[0] * abs(a[0]), coefficient[1] * a[1] * abs(a[1]), coefficient[2] * a[2] * abs(a[2])


@inlined
def symmetric_adjugate(a: tuple[float, ...]) -> tuple[tuple[float, ...], float]:
    """Adjugate, and inverse of the determinant, of a symmetric 3x3 matrix given as (11, 12, 13, 22, 23, 33)."""
    c11 = a[3] * a[5] - a[4] * a[4]
    c12 = a[2] * a[4] - a[1] * a[5]
    c13 = a[1] * a[4] - a[2] * a[3]
    c22 = a[0] * a[5] - a[2] * a[2]
    c23 = a[1] * a[2] - a[0] * a[4]
    c33 = a[0] * a[3] - a[1] * a[1]
    d = 1.0 / (a[0] * c11 + a[1] * c12 + a[2] * c13)
    return (c11, c12, c13, c22, c23, c33), d


@inlined
def symmetric_times(a: tuple[float, ...], b: Vector) -> Vector:
    """A b with the symmetric A as (11, 12, 13, 22, 23, 33)."""
    return (
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2],
        a[1] * b[0] + a[3] * b[1] + a[4] * b[2],
        a[2] * b[0] + a[4] * b[1] + a[5] * b[2],
    )


@inlined
def outer(a: Vector, b: Vector) -> Matrix:
    """a b'."""
    return (
        a[0] * b[0], a[0] * b[1], a[0] * b[2],
        a[1] * b[0], a[1] * b[1], a[1] * b[2],
        a[2] * b[0], a[2] * b[1], a[2] * b[2],
    )  # fmt: skip


@inlined
def plus_outer(m: Matrix, a: Vector, b: Vector) -> Matrix:
    """M + a b'."""
    return (
        m[0] + a[0] * b[0], m[1] + a[0] * b[1], m[2] + a[0] * b[2],
        m[3] + a[1] * b[0], m[4] + a[1] * b[1], m[5] + a[1] * b[2],
        m[6] + a[2] * b[0], m[7] + a[2] * b[1], m[8] + a[2] * b[2],
    )  # fmt: skip


@inlined
def product(a: Matrix, b: Matrix) -> Matrix:
    """A B."""
    return (
        a[0] * b[0] + a[1] * b[3] + a[2] * b[6], a[0] * b[1] + a[1] * b[4] + a[2] * b[7],
        a[0] * b[2] + a[1] * b[5] + a[2] * b[8],
        a[3] * b[0] + a[4] * b[3] + a[5] * b[6], a[3] * b[1] + a[4] * b[4] + a[5] * b[7],
        a[3] * b[2] + a[4] * b[5] + a[5] * b[8],
        a[6] * b[0] + a[7] * b[3] + a[8] * b[6], a[6] * b[1] + a[7] * b[4] + a[8] * b[7],
        a[6] * b[2] + a[7] * b[5] + a[8] * b[8],
    )  # fmt: skip


@inlined
def plus_diagonal(a: Matrix, value: float) -> Matrix:
    """A + value 1."""
    return a[0] + value, a[1], a[2], a[3], a[4] + value, a[5], a[6], a[7], a[8] + value


@inlined
def inverse(m: Matrix) -> Matrix:
    """Inverse of a matrix, by its adjugate; not finite where it is singular."""
    p, q, r = m[4] * m[8] - m[5] * m[7], m[5] * m[6] - m[3] * m[8], m[3] * m[7] - m[4] * m[6]
    d = 1.0 / (m[0] * p + m[1] * q + m[2] * r)
    return (
        d * p, d * (m[2] * m[7] - m[1] * m[8]), d * (m[1] * m[5] - m[2] * m[4]),
        d * q, d * (m[0] * m[8] - m[2] * m[6]), d * (m[2] * m[3] - m[0] * m[5]),
        d * r, d * (m[1] * m[6] - m[0] * m[7]), d * (m[0] * m[4] - m[1] * m[3]),
    )  # fmt: skip
