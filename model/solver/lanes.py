"""The state of a march in memory and in registers: vectors of one rod or of several (lanes), and operations on them.

State of a rod: p 3, R 9, e = v - v* 3, u 3, q 3, w 3. In memory it is rows of one float per rod, lane after lane.
"""

from typing import Any

from tendond.model.numerics.compile import inlined
from tendond.model.numerics.simd import simd_load, simd_repeat, simd_store
from tendond.model.numerics.vectors import add, scale

STATE = 24
"""Numbers in the state of a rod at a point."""


@inlined
def vector(a: Any, start: int) -> Any:
    """Vector at `start` of an array of one dimension."""
    return a[start], a[start + 1], a[start + 2]


@inlined
def row_vector(a: Any, row: int, start: int) -> Any:
    """Vector at `start` of a row of an array of two dimensions."""
    return a[row, start], a[row, start + 1], a[row, start + 2]


@inlined
def write_vector(a: Any, row: int, start: int, values: Any) -> None:
    """Write a vector at `start` of a row of an array of two dimensions."""
    a[row, start], a[row, start + 1], a[row, start + 2] = values


@inlined
def lane_vector(z: Any, row: int, lanes: Any) -> Any:
    """Load the vector of all lanes at rows `row` to `row` + 2."""
    n = len(lanes)
    return simd_load(z, row * n, lanes), simd_load(z, (row + 1) * n, lanes), simd_load(z, (row + 2) * n, lanes)


@inlined
def store_vector(z: Any, row: int, lanes: Any, a: Any) -> None:
    """Store the vector of all lanes at rows `row` to `row` + 2."""
    width = len(lanes)
    simd_store(z, row * width, a[0])
    simd_store(z, (row + 1) * width, a[1])
    simd_store(z, (row + 2) * width, a[2])


@inlined
def load_state(z: Any, row: int, lanes: Any) -> Any:
    """Load the state of all lanes from row `row` on."""
    return (
        lane_vector(z, row, lanes),
        lane_vector(z, row + 3, lanes) + lane_vector(z, row + 6, lanes) + lane_vector(z, row + 9, lanes),
        lane_vector(z, row + 12, lanes),
        lane_vector(z, row + 15, lanes),
        lane_vector(z, row + 18, lanes),
        lane_vector(z, row + 21, lanes),
    )


@inlined
def store_state(z: Any, row: int, lanes: Any, state: Any) -> None:
    """Store the state of all lanes from row `row` on."""
    p, R, e, u, q, w = state
    store_vector(z, row, lanes, p)
    store_vector(z, row + 3, lanes, (R[0], R[1], R[2]))
    store_vector(z, row + 6, lanes, (R[3], R[4], R[5]))
    store_vector(z, row + 9, lanes, (R[6], R[7], R[8]))
    store_vector(z, row + 12, lanes, e)
    store_vector(z, row + 15, lanes, u)
    store_vector(z, row + 18, lanes, q)
    store_vector(z, row + 21, lanes, w)


@inlined
def advance_state(state: Any, h: float, slope: Any) -> Any:
    """Add h times the state's rates along the rod."""
    p, R, e, u, q, w = state
    p_s, D, e_s, u_s, q_s, w_s = slope
    return (
        add(p, scale(h, p_s)),
        add((R[0], R[1], R[2]), scale(h, (D[0], D[1], D[2])))
        + add((R[3], R[4], R[5]), scale(h, (D[3], D[4], D[5])))
        + add((R[6], R[7], R[8]), scale(h, (D[6], D[7], D[8]))),
        add(e, scale(h, e_s)),
        add(u, scale(h, u_s)),
        add(q, scale(h, q_s)),
        add(w, scale(h, w_s)),
    )


@inlined
def combine_rates(z: Any, node: int, stored: int, size: int, ds: float, factors: Any, count: int) -> None:
    """Stage state = node + ds * sum of the first `count` stored rates, each times its factor."""
    for j in range(size):
        z[j] = z[node + j]
    for t in range(count):
        factor = ds * factors[t]
        if factor != 0.0:
            for j in range(size):
                z[j] += factor * z[stored + t * size + j]


@inlined
def orthonormalised(state: Any) -> Any:
    """The state with R brought back to SO(3) by two Newton-Schulz iterations, R <- R (3 I - R'R)/2."""
    p, R, e, u, q, w = state
    for _ in range(2):
        g11 = 0.5 * (R[0] * R[0] + R[3] * R[3] + R[6] * R[6])
        g22 = 0.5 * (R[1] * R[1] + R[4] * R[4] + R[7] * R[7])
        g33 = 0.5 * (R[2] * R[2] + R[5] * R[5] + R[8] * R[8])
        g12 = 0.5 * (R[0] * R[1] + R[3] * R[4] + R[6] * R[7])
        g13 = 0.5 * (R[0] * R[2] + R[3] * R[5] + R[6] * R[8])
        g23 = 0.5 * (R[1] * R[2] + R[4] * R[5] + R[7] * R[8])
        R = (
            R[0] * (1.5 - g11) - R[1] * g12 - R[2] * g13,
            R[1] * (1.5 - g22) - R[0] * g12 - R[2] * g23,
            R[2] * (1.5 - g33) - R[0] * g13 - R[1] * g23,
            R[3] * (1.5 - g11) - R[4] * g12 - R[5] * g13,
            R[4] * (1.5 - g22) - R[3] * g12 - R[5] * g23,
            R[5] * (1.5 - g33) - R[3] * g13 - R[4] * g23,
            R[6] * (1.5 - g11) - R[7] * g12 - R[8] * g13,
            R[7] * (1.5 - g22) - R[6] * g12 - R[8] * g23,
            R[8] * (1.5 - g33) - R[6] * g13 - R[7] * g23,
        )
    return p, R, e, u, q, w


@inlined
def repeat_vector(a: Any, times: Any) -> Any:
    """Repeat each component as `simd_repeat` does."""
    return simd_repeat(a[0], times), simd_repeat(a[1], times), simd_repeat(a[2], times)
