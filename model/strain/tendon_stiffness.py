"""Second derivatives of the tendons' path lengths: what their tensions add to the stiffness."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.products import BLOCK, HALF, Lines, add_products, padded
from tendond.model.numerics.simd import simd_load, simd_multiply_add, simd_store, simd_sum, simd_vector
from tendond.model.strain.tendons import Paths

Array = NDArray[np.float64]

_ONE = (0.0,)


@inlined
def _find_block(paths: Paths, j: int) -> None:
    """Write the stiffness by bending, twist and stretch at a tendon point to `paths.block`.

    P = 1 - t t' stands on the tangent's derivatives (0, 0, y), (0, 0, -x), (-y, x, 0) by u, and (0, 0, 1) by v_3.
    """
    block, width = paths.block, len(paths.shortening)
    b00 = b10 = b11 = b20 = b21 = b22 = b50 = b51 = b52 = b55 = simd_vector(_ONE, BLOCK)
    for lane in range(0, width, HALF):
        at, to = 5 * j * width + lane, 4 * j * width + lane
        x, y = simd_load(paths.routes, at, BLOCK), simd_load(paths.routes, at + width, BLOCK)
        tx, ty = simd_load(paths.tangent, to, BLOCK), simd_load(paths.tangent, to + width, BLOCK)
        tz = simd_load(paths.tangent, to + 2 * width, BLOCK)
        w = simd_load(paths.tangent, to + 3 * width, BLOCK) * simd_load(paths.tension, lane, BLOCK)
        pz, spun = w * (1.0 - tz * tz), x * ty - y * tx
        uz = -w * spun * tz
        b00, b10, b11 = b00 + y * y * pz, b10 - x * y * pz, b11 + x * x * pz
        b20, b21, b22 = b20 + y * uz, b21 - x * uz, b22 + w * (x * x + y * y - spun * spun)
        b50, b51, b52, b55 = b50 + y * pz, b51 - x * pz, b52 + uz, b55 + pz
    block[0, 0], block[1, 1] = simd_sum(b00, _ONE), simd_sum(b11, _ONE)
    block[2, 2], block[5, 5] = simd_sum(b22, _ONE), simd_sum(b55, _ONE)
    block[1, 0] = block[0, 1] = simd_sum(b10, _ONE)
    block[2, 0] = block[0, 2] = simd_sum(b20, _ONE)
    block[2, 1] = block[1, 2] = simd_sum(b21, _ONE)
    block[5, 0] = block[0, 5] = simd_sum(b50, _ONE)
    block[5, 1] = block[1, 5] = simd_sum(b51, _ONE)
    block[5, 2] = block[2, 5] = simd_sum(b52, _ONE)


@inlined
def _find_shear(paths: Paths, j: int) -> None:
    """Write the stiffness by shear at a tendon point to `paths.block`; (1, 0, 0) and (0, 1, 0) by v_1 and v_2."""
    block, width = paths.block, len(paths.shortening)
    b30 = b31 = b32 = b33 = b40 = b41 = b42 = b43 = b44 = b53 = b54 = simd_vector(_ONE, BLOCK)
    for lane in range(0, width, HALF):
        at, to = 5 * j * width + lane, 4 * j * width + lane
        x, y = simd_load(paths.routes, at, BLOCK), simd_load(paths.routes, at + width, BLOCK)
        tx, ty = simd_load(paths.tangent, to, BLOCK), simd_load(paths.tangent, to + width, BLOCK)
        tz = simd_load(paths.tangent, to + 2 * width, BLOCK)
        w = simd_load(paths.tangent, to + 3 * width, BLOCK) * simd_load(paths.tension, lane, BLOCK)
        spun, xz, yz = x * ty - y * tx, w * tx * tz, w * ty * tz
        b30, b31, b32 = b30 - y * xz, b31 + x * xz, b32 - w * (y + spun * tx)
        b40, b41, b42 = b40 - y * yz, b41 + x * yz, b42 + w * (x - spun * ty)
        b33, b43, b44 = b33 + w * (1.0 - tx * tx), b43 - w * tx * ty, b44 + w * (1.0 - ty * ty)
        b53, b54 = b53 - xz, b54 - yz
    block[3, 3], block[4, 4] = simd_sum(b33, _ONE), simd_sum(b44, _ONE)
    block[3, 0] = block[0, 3] = simd_sum(b30, _ONE)
    block[3, 1] = block[1, 3] = simd_sum(b31, _ONE)
    block[3, 2] = block[2, 3] = simd_sum(b32, _ONE)
    block[4, 0] = block[0, 4] = simd_sum(b40, _ONE)
    block[4, 1] = block[1, 4] = simd_sum(b41, _ONE)
    block[4, 2] = block[2, 4] = simd_sum(b42, _ONE)
    block[4, 3] = block[3, 4] = simd_sum(b43, _ONE)
    block[5, 3] = block[3, 5] = simd_sum(b53, _ONE)
    block[5, 4] = block[4, 5] = simd_sum(b54, _ONE)


@lean
def add_tendon_stiffness(tension: Any, paths: Paths, out: Array) -> None:
    """Subtract the sum of tension . d2(displacement)/dq dq from `out`, shape (n, n).

    After `find_paths` at the same strains, whose tangents it takes.
    """
    width, used, modes, spread, total = padded(len(out)), len(paths.used), paths.modes, paths.spread, paths.total
    any_tension = False
    for i in range(len(tension)):
        paths.tension[i] = tension[i]
        any_tension |= tension[i] != 0.0
    if not any_tension:
        return
    sheared = False
    for c in range(used):
        sheared |= paths.used[c] == 3 or paths.used[c] == 4
    total[:] = 0.0
    begin = 0
    for j in range(len(paths.first)):
        first, last = paths.first[j], paths.last[j]
        _find_block(paths, j)
        if sheared:
            _find_shear(paths, j)
        for b in range(first // HALF * HALF, last, HALF):
            for c in range(used):
                value = paths.block[paths.used[c], paths.used[0]] * simd_load(modes, j * used * width + b, BLOCK)
                for other in range(1, used):
                    along = simd_load(modes, (j * used + other) * width + b, BLOCK)
                    value = simd_multiply_add(paths.block[paths.used[c], paths.used[other]], along, value)
                simd_store(spread, (j * used + c) * width + b, value)
        if j + 1 == len(paths.first) or paths.first[j + 1] != first:
            at, count = begin * used * width, (j + 1 - begin) * used
            add_products(
                Lines(modes, at, width), Lines(spread, at, width), count, (first, last), (first, last),
                Lines(total, 0, width),
            )  # fmt: skip
            for a in range(first, last):
                for b in range(first, last):
                    out[a, b] += total[a * width + b]
            begin = j + 1
