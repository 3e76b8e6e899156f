"""Linear systems with many right-hand sides inside kernels: all columns of a row at once, side by side in memory."""

from typing import Any

from tendond.model.numerics.compile import inlined


@inlined
def solve_lu_columns(a: Any, rows: Any, b: Any, n: int) -> None:
    """Solve a x = b with the factors of `factor_lu` for all columns of the first n rows of b, in place."""
    count = b.shape[1]
    for column in range(n):
        pivot = rows[column]
        if pivot != column:
            for j in range(count):
                b[column, j], b[pivot, j] = b[pivot, j], b[column, j]
    for row in range(n):
        for k in range(row):
            factor = a[row, k]
            for j in range(count):
                b[row, j] -= factor * b[k, j]
    for row in range(n - 1, -1, -1):
        for k in range(row + 1, n):
            factor = a[row, k]
            for j in range(count):
                b[row, j] -= factor * b[k, j]
        inverse = 1.0 / a[row, row]
        for j in range(count):
            b[row, j] *= inverse


@inlined
def solve_symmetric_columns(a: Any, b: Any, n: int, first: int) -> None:
    """Solve a x = b with the factors of `factor_symmetric` for all columns of n rows of b from `first`, in place."""
    count = b.shape[1]
    for column in range(n):
        inverse = 1.0 / a[column, column]
        for row in range(column + 1, n):
            factor = a[column, row] * inverse
            for j in range(count):
                b[first + row, j] -= factor * b[first + column, j]
    for row in range(n - 1, -1, -1):
        for k in range(row + 1, n):
            factor = a[row, k]
            for j in range(count):
                b[first + row, j] -= factor * b[first + k, j]
        inverse = 1.0 / a[row, row]
        for j in range(count):
            b[first + row, j] *= inverse
