"""Systems with many right-hand sides, and products: sixteen columns of four rows at a time stay in registers.

One row at a time, each sum waits for the one before it. Matrices are padded rows, as those of `products`.
"""

from typing import Any, NamedTuple

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.products import BLOCK, HALF, LANES
from tendond.model.numerics.simd import simd_load, simd_multiply_add, simd_store, simd_vector

ROWS = 4


class Factors(NamedTuple):
    """Numbers of an array that rows are multiplied by: at `at` + i across + r along for the row r in the sum i."""

    array: Any
    at: int
    across: int
    along: int


@inlined
def _sum_four(by: Factors, b: Any, columns: int, j: int, first: int, last: int) -> Any:
    """Return four sums of the rows of b from `first` to `last`, each times a factor, in sixteen columns from j."""
    array, one, two, three = by.array, by.across, 2 * by.across, 3 * by.across
    s00 = s01 = s10 = s11 = s20 = s21 = s30 = s31 = simd_vector((0.0,), BLOCK)
    for r in range(first, last):
        at, here = by.at + r * by.along, r * columns + j
        x, y = simd_load(b, here, BLOCK), simd_load(b, here + HALF, BLOCK)
        s00, s01 = simd_multiply_add(array[at], x, s00), simd_multiply_add(array[at], y, s01)
        s10, s11 = simd_multiply_add(array[at + one], x, s10), simd_multiply_add(array[at + one], y, s11)
        s20, s21 = simd_multiply_add(array[at + two], x, s20), simd_multiply_add(array[at + two], y, s21)
        s30, s31 = simd_multiply_add(array[at + three], x, s30), simd_multiply_add(array[at + three], y, s31)
    return (s00, s01), (s10, s11), (s20, s21), (s30, s31)


@inlined
def _sum_one(by: Factors, b: Any, columns: int, j: int, first: int, last: int) -> Any:
    """Return one sum of the rows of b from `first` to `last`, each times a factor, in sixteen columns from j."""
    one = two = simd_vector((0.0,), BLOCK)
    for r in range(first, last):
        factor, here = by.array[by.at + r * by.along], r * columns + j
        one = simd_multiply_add(factor, simd_load(b, here, BLOCK), one)
        two = simd_multiply_add(factor, simd_load(b, here + HALF, BLOCK), two)
    return one, two


@inlined
def _add(b: Any, at: int, factor: float, values: Any, scale: float) -> Any:
    """Write scale (b + factor values), sixteen numbers from `at`."""
    simd_store(b, at, simd_multiply_add(factor, values[0], simd_load(b, at, BLOCK)) * scale)
    simd_store(b, at + HALF, simd_multiply_add(factor, values[1], simd_load(b, at + HALF, BLOCK)) * scale)


@lean
def solve_lu_columns(a: Any, rows: Any, b: Any, size: int, width: int, columns: int) -> None:
    """Solve a x = b with the factors of `factor_lu` for all columns of b, in place; its rows are `columns` wide."""
    whole = size // ROWS * ROWS
    for column in range(size):
        pivot = rows[column]
        if pivot != column:
            for j in range(columns):
                b[column * columns + j], b[pivot * columns + j] = b[pivot * columns + j], b[column * columns + j]
    for j in range(0, columns, LANES):
        for row in range(0, whole, ROWS):
            s0, s1, s2, s3 = _sum_four(Factors(a, row * width, width, 1), b, columns, j, 0, row)
            _add(b, row * columns + j, -1.0, s0, 1.0)
            _add(b, (row + 1) * columns + j, -1.0, s1, 1.0)
            _add(b, (row + 2) * columns + j, -1.0, s2, 1.0)
            _add(b, (row + 3) * columns + j, -1.0, s3, 1.0)
            for near in range(row + 1, row + ROWS):
                own = _sum_one(Factors(a, near * width, 0, 1), b, columns, j, row, near)
                _add(b, near * columns + j, -1.0, own, 1.0)
        for row in range(whole, size):
            own = _sum_one(Factors(a, row * width, 0, 1), b, columns, j, 0, row)
            _add(b, row * columns + j, -1.0, own, 1.0)
        for row in range(size - 1, whole - 1, -1):
            own = _sum_one(Factors(a, row * width, 0, 1), b, columns, j, row + 1, size)
            _add(b, row * columns + j, -1.0, own, 1.0 / a[row * width + row])
        for row in range(whole - ROWS, -1, -ROWS):
            s0, s1, s2, s3 = _sum_four(Factors(a, row * width, width, 1), b, columns, j, row + ROWS, size)
            _add(b, row * columns + j, -1.0, s0, 1.0)
            _add(b, (row + 1) * columns + j, -1.0, s1, 1.0)
            _add(b, (row + 2) * columns + j, -1.0, s2, 1.0)
            _add(b, (row + 3) * columns + j, -1.0, s3, 1.0)
            for near in range(row + ROWS - 1, row - 1, -1):
                own = _sum_one(Factors(a, near * width, 0, 1), b, columns, j, near + 1, row + ROWS)
                _add(b, near * columns + j, -1.0, own, 1.0 / a[near * width + near])


@lean
def solve_symmetric_columns(a: Any, b: Any, size: int, width: int, columns: int) -> None:
    """Solve a x = b with the factors of `factor_symmetric` for all columns of b, in place."""
    whole = size // ROWS * ROWS
    for j in range(0, columns, LANES):
        for row in range(0, whole, ROWS):
            s0, s1, s2, s3 = _sum_four(Factors(a, row, 1, width), b, columns, j, 0, row)
            _add(b, row * columns + j, -1.0, s0, 1.0)
            _add(b, (row + 1) * columns + j, -1.0, s1, 1.0)
            _add(b, (row + 2) * columns + j, -1.0, s2, 1.0)
            _add(b, (row + 3) * columns + j, -1.0, s3, 1.0)
            for near in range(row, row + ROWS):
                own = _sum_one(Factors(a, near, 0, width), b, columns, j, row, near)
                _add(b, near * columns + j, -1.0, own, 1.0 / a[near * width + near])
        for row in range(whole, size):
            own = _sum_one(Factors(a, row, 0, width), b, columns, j, 0, row)
            _add(b, row * columns + j, -1.0, own, 1.0 / a[row * width + row])
        for row in range(size - 1, whole - 1, -1):
            own = _sum_one(Factors(a, row * width, 0, 1), b, columns, j, row + 1, size)
            _add(b, row * columns + j, -1.0 / a[row * width + row], own, 1.0)
        for row in range(whole - ROWS, -1, -ROWS):
            s0, s1, s2, s3 = _sum_four(Factors(a, row * width, width, 1), b, columns, j, row + ROWS, size)
            _add(b, row * columns + j, -1.0 / a[row * width + row], s0, 1.0)
            _add(b, (row + 1) * columns + j, -1.0 / a[(row + 1) * width + row + 1], s1, 1.0)
            _add(b, (row + 2) * columns + j, -1.0 / a[(row + 2) * width + row + 2], s2, 1.0)
            _add(b, (row + 3) * columns + j, -1.0 / a[(row + 3) * width + row + 3], s3, 1.0)
            for near in range(row + ROWS - 2, row - 1, -1):
                own = _sum_one(Factors(a, near * width, 0, 1), b, columns, j, near + 1, row + ROWS)
                _add(b, near * columns + j, -1.0 / a[near * width + near], own, 1.0)


@lean
def add_transformed(a: Any, b: Any, size: int, width: int, columns: int, out: Any) -> None:
    """Add a b to out: a is square, of that size, its rows `width` wide; those of b and out are `columns` wide."""
    whole = size // ROWS * ROWS
    for j in range(0, columns, LANES):
        for row in range(0, whole, ROWS):
            s0, s1, s2, s3 = _sum_four(Factors(a, row * width, width, 1), b, columns, j, 0, size)
            _add(out, row * columns + j, 1.0, s0, 1.0)
            _add(out, (row + 1) * columns + j, 1.0, s1, 1.0)
            _add(out, (row + 2) * columns + j, 1.0, s2, 1.0)
            _add(out, (row + 3) * columns + j, 1.0, s3, 1.0)
        for row in range(whole, size):
            _add(out, row * columns + j, 1.0, _sum_one(Factors(a, row * width, 0, 1), b, columns, j, 0, size), 1.0)
