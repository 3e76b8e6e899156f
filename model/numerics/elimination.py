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
def _subtract_four(a: Any, at: int, width: int, factors: Any, row: Any, start: int, first: int, last: int) -> None:
    """Subtract a row, each time with another factor, from four that follow each other, in blocks as `_subtract`."""
    f0, f1, f2, f3 = factors
    for j in range(first, last, HALF):
        other, one, two = simd_load(row, start + j, BLOCK), at + j, at + width + j
        three, four = two + width, two + 2 * width
        simd_store(a, one, simd_multiply_add(-f0, other, simd_load(a, one, BLOCK)))
        simd_store(a, two, simd_multiply_add(-f1, other, simd_load(a, two, BLOCK)))
        simd_store(a, three, simd_multiply_add(-f2, other, simd_load(a, three, BLOCK)))
        simd_store(a, four, simd_multiply_add(-f3, other, simd_load(a, four, BLOCK)))


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
        here, pivot = column * width, column
        largest = abs(a[here + column])
        for row in range(column + 1, size):
            value = abs(a[row * width + column])
            if value > largest:
                pivot, largest = row, value
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
        whole = size - (size - column - 1) % 4
        for row in range(column + 1, whole, 4):
            at = row * width + column
            f0, f1 = a[at] * inverse, a[at + width] * inverse
            f2, f3 = a[at + 2 * width] * inverse, a[at + 3 * width] * inverse
            a[at], a[at + width], a[at + 2 * width], a[at + 3 * width] = f0, f1, f2, f3
            _subtract_four(a, row * width, width, (f0, f1, f2, f3), room, 0, begin, size)
        for row in range(whole, size):
            factor = a[row * width + column] * inverse
            a[row * width + column] = factor
            _subtract(a, row * width, factor, room, 0, begin, size)
    return True


@inlined
def _solve_upper(a: Any, room: Any, b: Any, size: int, width: int) -> None:
    """Solve U x = c for the upper rows of a, c the first row of `room`; its second takes x, from 0, as b does."""
    whole = size // 4 * 4
    for row in range(size - 1, whole - 1, -1):
        value = room[row] - _product(a, row * width, room, width, row // HALF * HALF, size)
        b[row] = room[width + row] = value / a[row * width + row]
    for row in range(whole - 4, -1, -4):
        at, begin = row * width, row // HALF * HALF
        d0 = at + row
        d1, d2, d3 = d0 + width + 1, d0 + 2 * (width + 1), d0 + 3 * (width + 1)
        s0, s1 = _product(a, at, room, width, begin, size), _product(a, at + width, room, width, begin, size)
        s2 = _product(a, at + 2 * width, room, width, begin, size)
        x3 = (room[row + 3] - _product(a, at + 3 * width, room, width, begin, size)) / a[d3]
        x2 = (room[row + 2] - s2 - a[d2 + 1] * x3) / a[d2]
        x1 = (room[row + 1] - s1 - a[d1 + 1] * x2 - a[d1 + 2] * x3) / a[d1]
        x0 = (room[row] - s0 - a[d0 + 1] * x1 - a[d0 + 2] * x2 - a[d0 + 3] * x3) / a[d0]
        b[row], b[row + 1], b[row + 2], b[row + 3] = x0, x1, x2, x3
        at = width + row
        room[at], room[at + 1], room[at + 2], room[at + 3] = x0, x1, x2, x3


@lean
def solve_lu(a: Any, rows: Any, b: Any, size: int, width: int, room: Any) -> None:
    """Solve a x = b with the factors of `factor_lu`; x replaces b, shape (size,)."""
    room[:] = 0.0
    for column in range(size):
        pivot = rows[column]
        if pivot != column:
            b[column], b[pivot] = b[pivot], b[column]
    whole = size // 4 * 4
    for row in range(0, whole, 4):  # what is not yet known is 0
        at = row * width
        one, two = at + width + row, at + 2 * width + row
        s0, s1 = _product(a, at, room, 0, 0, row), _product(a, at + width, room, 0, 0, row)
        s2, s3 = _product(a, at + 2 * width, room, 0, 0, row), _product(a, at + 3 * width, room, 0, 0, row)
        x0 = b[row] - s0
        x1 = b[row + 1] - s1 - a[one] * x0
        x2 = b[row + 2] - s2 - a[two] * x0 - a[two + 1] * x1
        x3 = b[row + 3] - s3 - a[two + width] * x0 - a[two + width + 1] * x1 - a[two + width + 2] * x2
        room[row], room[row + 1], room[row + 2], room[row + 3] = x0, x1, x2, x3
    for row in range(whole, size):
        room[row] = b[row] - _product(a, row * width, room, 0, 0, row + 1)
    _solve_upper(a, room, b, size, width)


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
        begin = min(size, column // 4 * 4 + 4)  # rows from a multiple of four on begin in the same block
        for row in range(column + 1, begin):
            _subtract(a, row * width, a[here + row] * inverse, a, here, row // HALF * HALF, size)
        whole = size // 4 * 4
        for row in range(begin, whole, 4):
            f0, f1 = a[here + row] * inverse, a[here + row + 1] * inverse
            f2, f3 = a[here + row + 2] * inverse, a[here + row + 3] * inverse
            _subtract_four(a, row * width, width, (f0, f1, f2, f3), a, here, row // HALF * HALF, size)
        for row in range(max(begin, whole), size):
            _subtract(a, row * width, a[here + row] * inverse, a, here, row // HALF * HALF, size)
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
    for row in range(size):
        room[row] = b[row]
    _solve_upper(a, room, b, size, width)
