"""Linear systems of the kernels against numpy's, for sizes around the four rows and eight columns done at once."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.model.numerics.columns import add_transformed, solve_lu_columns, solve_symmetric_columns
from tendond.model.numerics.elimination import factor_lu, factor_symmetric, solve_lu, solve_symmetric
from tendond.model.numerics.products import Lines, add_products

Array = NDArray[np.float64]

SIZES = (1, 3, 4, 7, 8, 12, 15, 17, 36)
COLUMNS = 32


def rows_of(matrix: Array) -> Array:
    """Padded rows of a matrix, in a row."""
    width = -(-len(matrix) // 16) * 16
    padded = np.zeros((width, width))
    padded[: len(matrix), : len(matrix)] = matrix
    return padded.reshape(-1)


def drawn(size: int) -> tuple[Array, Array, int]:
    """A matrix, right-hand sides, and the width of its rows."""
    rng = np.random.default_rng(size)
    return rng.normal(size=(size, size)), rng.normal(size=(size, COLUMNS)), -(-size // 16) * 16


@pytest.mark.parametrize("size", SIZES)
def test_systems_with_pivots_are_solved(size: int) -> None:
    matrix, sides, width = drawn(size)
    factors, rows, room = rows_of(matrix), np.zeros(size, dtype=np.int64), np.zeros(3 * width)
    assert factor_lu(factors, rows, size, width, room)
    one, all_of_them = sides[:, 0].copy(), sides.reshape(-1).copy()
    solve_lu(factors, rows, one, size, width, room)
    solve_lu_columns(factors, rows, all_of_them, size, width, COLUMNS)
    expected = np.linalg.solve(matrix, sides)
    assert one == pytest.approx(expected[:, 0], rel=1e-9, abs=1e-9)
    assert all_of_them.reshape(size, COLUMNS) == pytest.approx(expected, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("size", SIZES)
def test_symmetric_systems_are_solved(size: int) -> None:
    half, sides, width = drawn(size)
    matrix = half @ half.T + np.eye(size)
    factors, room = rows_of(np.triu(matrix)), np.zeros(3 * width)
    assert factor_symmetric(factors, size, width)
    one, all_of_them = sides[:, 0].copy(), sides.reshape(-1).copy()
    solve_symmetric(factors, one, size, width, room)
    solve_symmetric_columns(factors, all_of_them, size, width, COLUMNS)
    expected = np.linalg.solve(matrix, sides)
    assert one == pytest.approx(expected[:, 0], rel=1e-9, abs=1e-9)
    assert all_of_them.reshape(size, COLUMNS) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_what_cannot_be_solved_is_said() -> None:
    rows, room = np.zeros(12, dtype=np.int64), np.zeros(48)
    for broken in (np.zeros((12, 12)), np.full((12, 12), np.nan)):
        assert not factor_lu(rows_of(broken), rows, 12, 16, room)
        assert not factor_symmetric(rows_of(broken), 12, 16)
    assert not factor_symmetric(rows_of(-np.eye(12)), 12, 16)


@pytest.mark.parametrize("size", SIZES)
def test_a_product_is_added(size: int) -> None:
    matrix, sides, width = drawn(size)
    out = np.ones(size * COLUMNS)
    add_transformed(rows_of(matrix), sides.reshape(-1).copy(), size, width, COLUMNS, out)
    assert out.reshape(size, COLUMNS) == pytest.approx(1.0 + matrix @ sides)


@pytest.mark.parametrize(("of", "by"), [((0, 36), (0, 36)), ((4, 9), (8, 20)), ((10, 15), (16, 39)), ((0, 0), (0, 8))])
def test_products_of_rows_stay_within_the_columns_asked_for(of: tuple[int, int], by: tuple[int, int]) -> None:
    rng = np.random.default_rng(1)
    left, right = np.zeros((5, 48)), np.zeros((5, 48))
    left[:, of[0] : of[1]] = rng.normal(size=(5, of[1] - of[0]))
    right[:, by[0] : by[1]] = rng.normal(size=(5, by[1] - by[0]))
    out = np.zeros(48 * 48)
    add_products(Lines(left.reshape(-1), 0, 48), Lines(right.reshape(-1), 0, 48), 5, of, by, Lines(out, 0, 48))
    assert out.reshape(48, 48) == pytest.approx(left.T @ right)
