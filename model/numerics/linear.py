"""Small dense linear systems inside kernels, without allocation or LAPACK."""

from typing import Any

from tendond.model.numerics.compile import inlined


@inlined
def solve_in_place(a: Any, b: Any, size: int) -> bool:
    """Solve a x = b by Gaussian elimination with partial pivoting; x replaces b, a is destroyed.

    Args:
        a: shape at least (size, size).
        b: shape at least (size,).

    Returns:
        False where a is singular or not finite.
    """
    for column in range(size):
        pivot = column
        for row in range(column + 1, size):
            if abs(a[row, column]) > abs(a[pivot, column]):
                pivot = row
        largest = abs(a[pivot, column])
        if not (largest > 0.0 and largest < 1e300):
            return False
        if pivot != column:
            for j in range(column, size):
                a[column, j], a[pivot, j] = a[pivot, j], a[column, j]
            b[column], b[pivot] = b[pivot], b[column]
        inverse = 1.0 / a[column, column]
        for row in range(column + 1, size):
            factor = a[row, column] * inverse
            if factor != 0.0:
                for j in range(column + 1, size):
                    a[row, j] -= factor * a[column, j]
                b[row] -= factor * b[column]
    for row in range(size - 1, -1, -1):
        total = b[row]
        for j in range(row + 1, size):
            total -= a[row, j] * b[j]
        b[row] = total / a[row, row]
    return True
