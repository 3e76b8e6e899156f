"""Small dense linear systems inside kernels, without allocation or LAPACK."""

from typing import Any

from tendond.model.numerics.compile import inlined


@inlined
def _find_pivot(a: Any, column: int, size: int) -> int:
    """Return the row from the diagonal on that is largest in a column; -1 where it is 0, or not finite."""
    pivot = column
    for row in range(column + 1, size):
        if abs(a[row, column]) > abs(a[pivot, column]):
            pivot = row
    largest = abs(a[pivot, column])
    return pivot if largest > 0.0 and largest < 1e300 else -1


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
        pivot = _find_pivot(a, column, size)
        if pivot < 0:
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


@inlined
def factor_lu(a: Any, rows: Any, size: int) -> bool:
    """Factor a matrix in place by Gaussian elimination with partial pivoting, for `solve_lu`.

    Args:
        a: shape at least (size, size).
        rows: takes the row that each pivot was found in, shape at least (size,), integers.

    Returns:
        False where a is singular or not finite.
    """
    for column in range(size):
        pivot = _find_pivot(a, column, size)
        if pivot < 0:
            return False
        rows[column] = pivot
        if pivot != column:
            for j in range(size):
                a[column, j], a[pivot, j] = a[pivot, j], a[column, j]
        inverse = 1.0 / a[column, column]
        for row in range(column + 1, size):
            factor = a[row, column] * inverse
            a[row, column] = factor
            if factor != 0.0:
                for j in range(column + 1, size):
                    a[row, j] -= factor * a[column, j]
    return True


@inlined
def solve_lu(a: Any, rows: Any, b: Any, size: int) -> None:
    """Solve a x = b with the factors of `factor_lu`; x replaces b."""
    for column in range(size):
        pivot = rows[column]
        if pivot != column:
            b[column], b[pivot] = b[pivot], b[column]
    for row in range(size):
        total = b[row]
        for j in range(row):
            total -= a[row, j] * b[j]
        b[row] = total
    for row in range(size - 1, -1, -1):
        total = b[row]
        for j in range(row + 1, size):
            total -= a[row, j] * b[j]
        b[row] = total / a[row, row]


@inlined
def factor_symmetric(a: Any, size: int) -> bool:
    """Factor a symmetric matrix in place into L D L', for `solve_symmetric`; row j holds D_j and D_j L'.

    Returns:
        False where a is not positive definite.
    """
    for column in range(size):
        pivot = a[column, column]
        if not (pivot > 0.0 and pivot < 1e300):
            return False
        inverse = 1.0 / pivot
        for row in range(column + 1, size):
            factor = a[column, row] * inverse
            if factor != 0.0:
                for j in range(row, size):
                    a[row, j] -= factor * a[column, j]
    return True


@inlined
def solve_symmetric(a: Any, b: Any, size: int) -> None:
    """Solve a x = b with the factors of `factor_symmetric`; x replaces b."""
    for column in range(size):
        factor = b[column] / a[column, column]
        for row in range(column + 1, size):
            b[row] -= factor * a[column, row]
    for row in range(size - 1, -1, -1):
        total = b[row]
        for j in range(row + 1, size):
            total -= a[row, j] * b[j]
        b[row] = total / a[row, row]
