"""Dense linear systems of a few dozen unknowns inside kernels: Cholesky where it goes, Gauss with pivots else."""

import math

from tendond.model.numerics.compile import kernel


@kernel
def cholesky(a):  # type: ignore[no-untyped-def]
    """Factor a symmetric matrix in place, shape (n, n), its lower part L; false where it is not positive definite."""
    n = len(a)
    for j in range(n):
        value = a[j, j]
        for k in range(j):
            value -= a[j, k] * a[j, k]
        if not value > 0.0:
            return False
        root = math.sqrt(value)
        a[j, j] = root
        for i in range(j + 1, n):
            value = a[i, j]
            for k in range(j):
                value -= a[i, k] * a[j, k]
            a[i, j] = value / root
    return True


@kernel
def cholesky_solve(a, b):  # type: ignore[no-untyped-def]
    """Solve L L' x = b in place of b, shape (n,)."""
    n = len(b)
    for i in range(n):
        value = b[i]
        for k in range(i):
            value -= a[i, k] * b[k]
        b[i] = value / a[i, i]
    for i in range(n - 1, -1, -1):
        value = b[i]
        for k in range(i + 1, n):
            value -= a[k, i] * b[k]
        b[i] = value / a[i, i]


@kernel
def solve(a, b):  # type: ignore[no-untyped-def]
    """Solve a x = b in place of b, shape (n,), with partial pivots; `a` is overwritten. False where it is singular."""
    n = len(b)
    for j in range(n):
        pivot = j
        for i in range(j + 1, n):
            if abs(a[i, j]) > abs(a[pivot, j]):
                pivot = i
        if not abs(a[pivot, j]) > 0.0:
            return False
        if pivot != j:
            for k in range(n):
                a[j, k], a[pivot, k] = a[pivot, k], a[j, k]
            b[j], b[pivot] = b[pivot], b[j]
        for i in range(j + 1, n):
            factor = a[i, j] / a[j, j]
            if factor != 0.0:
                for k in range(j + 1, n):
                    a[i, k] -= factor * a[j, k]
                b[i] -= factor * b[j]
    for i in range(n - 1, -1, -1):
        value = b[i]
        for k in range(i + 1, n):
            value -= a[i, k] * b[k]
        b[i] = value / a[i, i]
    return True
