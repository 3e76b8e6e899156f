"""Sums of products of rows, A' B, inside kernels: blocks of the result stay in registers while the rows go by.

Loops over a dozen columns spend their time on starting and ending; here the innermost loop is over rows. Matrices are
arrays of one dimension, row after row, `width` wide: a multiple of `LANES`, zero in the columns that are not used.
"""

from typing import Any

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.simd import simd_load, simd_multiply_add, simd_store

HALF = 8
LANES = 2 * HALF
"""Columns that are done at once; `width` is a multiple of it."""

BLOCK = (0.0,) * HALF
"""Kind of vector that is loaded: `HALF` numbers."""


@inlined
def padded(columns: int) -> int:
    """Return the width of a matrix with that many columns."""
    return (columns + LANES - 1) // LANES * LANES


@lean
def add_products(
    left: Any, right: Any, width: int, rows: tuple[int, int], of: tuple[int, int], by: tuple[int, int], out: Any
) -> None:
    """Add to out[a, b] the sum of left[r, a] right[r, b] over rows r.

    Args:
        left: matrix. right: matrix.
        width: of all three.
        rows: first row, and the row after the last one.
        of: first a, and the one after the last; up to three more on either side are added where left is not zero.
        by: first b, and the one after the last; up to fifteen more on either side are added where right is not zero.
        out: matrix.
    """
    (first, last), (begin, end), (start, columns) = rows, of, by
    for a in range(begin // 4 * 4, end, 4):
        for b in range(start // LANES * LANES, columns, LANES):
            top, second = a * width + b, a * width + b + HALF
            third, fourth = top + 2 * width, second + 2 * width
            s00, s01 = simd_load(out, top, BLOCK), simd_load(out, second, BLOCK)
            s10, s11 = simd_load(out, top + width, BLOCK), simd_load(out, second + width, BLOCK)
            s20, s21 = simd_load(out, third, BLOCK), simd_load(out, fourth, BLOCK)
            s30, s31 = simd_load(out, third + width, BLOCK), simd_load(out, fourth + width, BLOCK)
            for r in range(first, last):
                one, two = simd_load(right, r * width + b, BLOCK), simd_load(right, r * width + b + HALF, BLOCK)
                at = r * width + a
                s00, s01 = simd_multiply_add(left[at], one, s00), simd_multiply_add(left[at], two, s01)
                s10, s11 = simd_multiply_add(left[at + 1], one, s10), simd_multiply_add(left[at + 1], two, s11)
                s20, s21 = simd_multiply_add(left[at + 2], one, s20), simd_multiply_add(left[at + 2], two, s21)
                s30, s31 = simd_multiply_add(left[at + 3], one, s30), simd_multiply_add(left[at + 3], two, s31)
            simd_store(out, top, s00)
            simd_store(out, second, s01)
            simd_store(out, top + width, s10)
            simd_store(out, second + width, s11)
            simd_store(out, third, s20)
            simd_store(out, fourth, s21)
            simd_store(out, third + width, s30)
            simd_store(out, fourth + width, s31)
