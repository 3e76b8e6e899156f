"""Sums of products of rows, A' B, inside kernels: blocks of the result stay in registers while the rows go by.

Loops over a dozen columns spend their time on starting and ending; here the innermost loop is over rows. Matrices are
arrays of one dimension, row after row; as a rule `padded` columns wide, zero in those that are not used.
"""

from typing import Any, NamedTuple

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


class Lines(NamedTuple):
    """Rows of an array of one dimension: the row r begins at `at` + r `stride`."""

    array: Any
    at: int
    stride: int


@inlined
def _add_block(left: Lines, right: Lines, count: int, a: int, b: int, out: Lines) -> None:
    """Add four rows and sixteen columns."""
    top = out.at + a * out.stride + b
    second, third = top + out.stride, top + 2 * out.stride
    fourth, array = top + 3 * out.stride, out.array
    s00, s01 = simd_load(array, top, BLOCK), simd_load(array, top + HALF, BLOCK)
    s10, s11 = simd_load(array, second, BLOCK), simd_load(array, second + HALF, BLOCK)
    s20, s21 = simd_load(array, third, BLOCK), simd_load(array, third + HALF, BLOCK)
    s30, s31 = simd_load(array, fourth, BLOCK), simd_load(array, fourth + HALF, BLOCK)
    for r in range(count):
        here, at, by = right.at + r * right.stride + b, left.at + r * left.stride + a, left.array
        one, two = simd_load(right.array, here, BLOCK), simd_load(right.array, here + HALF, BLOCK)
        s00, s01 = simd_multiply_add(by[at], one, s00), simd_multiply_add(by[at], two, s01)
        s10, s11 = simd_multiply_add(by[at + 1], one, s10), simd_multiply_add(by[at + 1], two, s11)
        s20, s21 = simd_multiply_add(by[at + 2], one, s20), simd_multiply_add(by[at + 2], two, s21)
        s30, s31 = simd_multiply_add(by[at + 3], one, s30), simd_multiply_add(by[at + 3], two, s31)
    simd_store(array, top, s00)
    simd_store(array, top + HALF, s01)
    simd_store(array, second, s10)
    simd_store(array, second + HALF, s11)
    simd_store(array, third, s20)
    simd_store(array, third + HALF, s21)
    simd_store(array, fourth, s30)
    simd_store(array, fourth + HALF, s31)


@inlined
def _add_half(left: Lines, right: Lines, count: int, a: int, b: int, out: Lines) -> None:
    """Add four rows and eight columns."""
    top, array = out.at + a * out.stride + b, out.array
    second, third, fourth = top + out.stride, top + 2 * out.stride, top + 3 * out.stride
    s0, s1 = simd_load(array, top, BLOCK), simd_load(array, second, BLOCK)
    s2, s3 = simd_load(array, third, BLOCK), simd_load(array, fourth, BLOCK)
    for r in range(count):
        at, by = left.at + r * left.stride + a, left.array
        one = simd_load(right.array, right.at + r * right.stride + b, BLOCK)
        s0, s1 = simd_multiply_add(by[at], one, s0), simd_multiply_add(by[at + 1], one, s1)
        s2, s3 = simd_multiply_add(by[at + 2], one, s2), simd_multiply_add(by[at + 3], one, s3)
    simd_store(array, top, s0)
    simd_store(array, second, s1)
    simd_store(array, third, s2)
    simd_store(array, fourth, s3)


@lean
def add_products(left: Lines, right: Lines, count: int, of: tuple[int, int], by: tuple[int, int], out: Lines) -> None:
    """Add to out[a, b] the sum of left[r, a] right[r, b] over so many rows r.

    Args:
        left: matrix. right: matrix.
        count: of rows.
        of: first a, and the one after the last; up to three more on either side are added where left is not zero.
        by: first b, and the one after the last; up to seven more on either side are added where right is not zero.
        out: matrix.
    """
    begin, end = by
    for a in range(of[0] // 4 * 4, of[1], 4):
        for b in range(begin // HALF * HALF, end, LANES):
            if b + HALF < end:
                _add_block(left, right, count, a, b, out)
            else:
                _add_half(left, right, count, a, b, out)
