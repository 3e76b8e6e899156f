"""Linear systems whose matrices are padded rows, as those of `products`: eight columns at a time.

`room` of the functions is an array of three rows. Many right-hand sides at once: `columns`.
"""

from typing import Any

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.products import BLOCK, HALF
from tendond.model.numerics.simd import simd_load, simd_multiply_add, simd_store, simd_sum

_ONE = (0.0,)


@inlined
def _subtract(into: Any, at: int, factor: float, row: Any, start: int, first: int, last: int) -> None:
    """Subtract `factor` times a row from another, in whole blocks from `first` to `last`."""
    for j in range(first, last, HALF):
        changed = simd_multiply_add(-factor, simd_load(row, start + j, BLOCK), simd_load(into, at + j, BLOCK))
        simd_store(into, at + j, changed)


@inlined
def _product(a: Any, at: int, b: Any, start: int, first: int, last: int) -> float:
    """Scalar product of two rows, in whole blocks from `first` to `last`."""
    total = simd_load(a, at + first, BLOCK) * simd_load(b, start + first, BLOCK)
    for j in range(first + HALF, last, HALF):
        total = total + simd_load(a, at + j, BLOCK) * simd_load(b, start + j, BLOCK)
    value: float = simd_sum(total, _ONE)
    return value


@lean
def factor_lu(a: Any, rows: Any, size: int, width: int, room: Any) -> bool:
    """Factor a matrix in place by Gaussian elimination with partial pivoting, for `solve_lu`.

    Args:
        a: matrix.
        rows: takes the row that each pivot was found in, shape (size,), integers.
        size: of the system.
        width: of a row.
        room: see the module.

    Returns:
        False where a is singular or not finite.
    """
    for column in range(size):
        pivot = column
        for row in range(column + 1, size):
            if abs(a[row * width + column]) > abs(a[pivot * width + column]):
                pivot = row
        here = column * width
        largest = abs(a[pivot * width + column])
        if not (largest > 0.0 and largest < 1e300):
            return False
        rows[column] = pivot
        if pivot != column:
            for j in range(0, width, HALF):
                upper, lower = simd_load(a, here + j, BLOCK), simd_load(a, pivot * width + j, BLOCK)
                simd_store(a, here + j, lower)
                simd_store(a, pivot * width + j, upper)
        inverse = 1.0 / a[here + column]
        begin = (column + 1) // HALF * HALF
        for j in range(begin, begin + HALF):  # the pivot's row without the factors that are kept in it
            room[j] = a[here + j] if column < j < width else 0.0
        for j in range(begin + HALF, width, HALF):
            simd_store(room, j, simd_load(a, here + j, BLOCK))
        for row in range(column + 1, size):
            factor = a[row * width + column] * inverse
            a[row * width + column] = factor
            _subtract(a, row * width, factor, room, 0, begin, width)
    return True


@lean
def solve_lu(a: Any, rows: Any, b: Any, size: int, width: int, room: Any) -> None:
    """Solve a x = b with the factors of `factor_lu`; x replaces b, shape (size,)."""
    room[:] = 0.0
    for column in range(size):
        pivot = rows[column]
        if pivot != column:
            b[column], b[pivot] = b[pivot], b[column]
    for row in range(size):  # what is not yet known is 0
        room[row] = b[row] - _product(a, row * width, room, 0, 0, row + 1)
    for row in range(size - 1, -1, -1):
        value = room[row] - _product(a, row * width, room, width, row // HALF * HALF, size)
        b[row] = value / a[row * width + row]
        room[width + row] = b[row]


@lean
def factor_symmetric(a: Any, size: int, width: int) -> bool:
    """Factor a symmetric matrix in place into L D L', for `solve_symmetric`; row j holds D_j and D_j L'.

    Returns:
        False where a is not positive definite.
    """
    for column in range(size):
        here = column * width
        pivot = a[here + column]
        if not (pivot > 0.0 and pivot < 1e300):
            return False
        inverse = 1.0 / pivot
        for row in range(column + 1, size):
            factor = a[here + row] * inverse
            if factor != 0.0:
                _subtract(a, row * width, factor, a, here, row // HALF * HALF, width)
    return True


@lean
def solve_symmetric(a: Any, b: Any, size: int, width: int, room: Any) -> None:
    """Solve a x = b with the factors of `factor_symmetric`; x replaces b, shape (size,)."""
    room[:] = 0.0
    for row in range(size):
        room[row] = b[row]
    for column in range(size):
        here = column * width
        b[column] = room[column]
        _subtract(room, 0, b[column] / a[here + column], a, here, (column + 1) // HALF * HALF, size)
    for row in range(size - 1, -1, -1):
        value = b[row] - _product(a, row * width, room, width, row // HALF * HALF, size)
        b[row] = value / a[row * width + row]
        room[width + row] = b[row]
