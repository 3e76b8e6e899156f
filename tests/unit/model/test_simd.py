"""SIMD vectors: a formula that holds for floats holds for vectors of them, in SIMD code."""

import math
from typing import Any

import numpy as np
import pytest

from tendond.model.numerics.compile import inlined
from tendond.model.numerics.simd import simd_load, simd_repeat, simd_store, simd_sum, simd_vector


@inlined
def formula(a: Any, b: Any, factor: float) -> Any:
    return (abs(-a) + factor) * (b - 1.0) / math.sqrt(factor * a * a + 2.0)


@inlined
def apply(like: Any, a: Any, b: Any, factor: float, out: Any) -> None:
    simd_store(out, 1, formula(simd_load(a, 1, like), simd_load(b, 0, like), factor))


@inlined
def sum_up(numbers: Any, lanes: Any, factors: Any, out: Any) -> None:
    simd_store(
        out, 0, simd_sum(simd_vector(numbers, lanes) * simd_repeat(simd_load(factors, 0, lanes), numbers), lanes)
    )


@pytest.mark.parametrize("width", [1, 2, 3, 4, 6, 8])
def test_a_formula_gives_a_simd_vector_what_it_gives_each_float(width: int) -> None:
    random = np.random.default_rng(width)
    a, b, out = random.normal(size=width + 2), random.normal(size=width), np.full(width + 2, 7.0)
    apply((0,) * width, a, b, 3.0, out)
    expected = [formula(float(a[1 + k]), float(b[k]), 3.0) for k in range(width)]
    np.testing.assert_allclose(out[1:-1], expected, rtol=1e-15)
    assert out[0] == out[-1] == 7.0, "neighbours must not be written"


@pytest.mark.parametrize("lanes", [1, 2, 8])
@pytest.mark.parametrize("count", [1, 3, 4, 6])
def test_a_sum_is_that_of_each_lane(count: int, lanes: int) -> None:
    numbers = tuple(float(2**k) for k in range(count))
    factors, out = 1.0 + np.arange(lanes), np.zeros(lanes)
    sum_up(numbers, (0,) * lanes, factors, out)
    np.testing.assert_array_equal(out, sum(numbers) * factors)


def test_a_root_of_a_simd_vector_is_one_instruction_for_all_of_it() -> None:
    """Look at LLVM's terms, whatever the processor makes of it."""
    out = np.zeros(10)
    apply((0,) * 8, np.ones(10), np.ones(8), 3.0, out)
    texts = [text for kinds, text in apply.inspect_llvm().items() if kinds[0].count == 8]
    assert texts
    assert all("@llvm.sqrt.v8f64" in text and "@llvm.sqrt.f64" not in text for text in texts)
