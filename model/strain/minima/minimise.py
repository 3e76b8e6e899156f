"""A descent to a minimum of the energy.

A Newton method, damped in the metric of the stiffness where it must (Levenberg and Marquardt), goes downhill from where
it starts: a rod that is loaded slowly gets to the same place, and what is found is stable. Dead moments are no gradient
of any energy: with them, the residual decides instead.
"""

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import lean
from tendond.model.numerics.elimination import factor_symmetric, solve_symmetric
from tendond.model.numerics.products import padded
from tendond.model.strain.layout import Layout
from tendond.model.strain.minima.energy import find_energy
from tendond.model.strain.minima.hessian import find_hessian
from tendond.model.strain.stepping.scratch import Loads, Scratch

Array = NDArray[np.float64]

ITERATIONS = 200
"""Largest number of Newton steps, beyond which a minimum counts as not found: a coil of silicone, in three sections,
needs 53 (`tendond bench rod --survey 1 --first 9932`)."""

ROUNDING = 1e-14
"""Part of the energies' sum below which a decrease is lost in rounding: 45 times that of a double."""

ATTAINED = 1e-12
"""Part of the energies' sum: where an undamped step promises less and none goes down, or a tenth of it after all
iterations, the minimum is reached to rounding. A hundred times `ROUNDING`: soft rods in coils wander at 4e-14 of it for
ever (`tendond bench rod --survey 1 --first 9466`)."""

APPROXIMATE = 4
"""Iterations with an approximate second derivative, which is cheaper. Statics from a neighbour take
3; near a coil of silicone the approximate one contracts by a hundredth only, and what goes down is lost in rounding
(`tendond bench rod --survey 1 --first 51814`), or it leads nowhere (`--first 23923`)."""

CONTRACTION = 0.05
"""Ratio of the decrement in one step, above which a new second derivative is worth its price. Chosen: it moves
time, not results, beyond the tolerance."""


@lean
def minimise(layout: Layout, loads: Loads, q: Array, rate: float, tolerance: float, work: Scratch) -> int:
    """Move q to a minimum of the energy, in place.

    Args:
        layout: of the robot.
        loads: on it.
        q: strains, shape (n,).
        rate: 1 / h of an implicit Euler step [1/s], after `begin_step`; 0: statics.
        tolerance: of q [rad], in the measure of energy.
        work: scratch arrays.

    Returns:
        Newton's iterations; -1 where they came to no end, and q has the least energy found.
    """
    n, width = len(q), padded(len(q))
    damping = 0.0
    moments = False
    if rate == 0.0:
        for k in range(1, len(layout.polar)):
            for c in range(3):
                moments |= loads.moment[k, c] != 0.0
    target = tolerance * tolerance * work.unit[0]
    step, trial, residual, last = work.correction, work.trial, work.pull, work.row
    energy, size = find_energy(layout, loads, q, rate, work)
    fresh, decrement, last_decrement = False, np.inf, np.inf
    for a in range(n):
        residual[a] = work.residual[a]
    for count in range(1, ITERATIONS + 1):
        last_decrement = np.inf  # of an undamped step from here
        if not fresh:
            find_hessian(layout, loads, q, rate, count > APPROXIMATE, work)
        while True:
            if not fresh:
                for a in range(n):
                    for b in range(n):
                        work.matrix[a * width + b] = work.hessian[a, b]
                    work.matrix[a * width + a] += damping * layout.stiffness[a, a]
                    step[a] = residual[a]
                positive = factor_symmetric(work.matrix, n, width)
                if positive:
                    solve_symmetric(work.matrix, step, n, width, work.solving)
            else:
                positive = True
            if positive:
                decrement = 0.0
                for a in range(n):
                    decrement += step[a] * residual[a]
                    trial[a] = q[a] - step[a]
                if damping == 0.0:
                    last_decrement = decrement
                found, other = find_energy(layout, loads, trial, rate, work)
                if moments:
                    for a in range(n):
                        last[a] = work.residual[a]
                    solve_symmetric(work.matrix, last, n, width, work.solving)
                    before = after = 0.0
                    for a in range(n):
                        before += layout.stiffness[a, a] * step[a] * step[a]
                        after += layout.stiffness[a, a] * last[a] * last[a]
                    if after < before or after < target:
                        break
                elif found <= energy - 1e-4 * decrement + ROUNDING * size:
                    break
            if fresh:
                fresh = False
                find_energy(layout, loads, q, rate, work)
                find_hessian(layout, loads, q, rate, count > APPROXIMATE, work)
                continue
            damping = max(4.0 * damping, 1e-3)
            if damping > 1e15:  # nothing goes down: this is the place, if rounding is what hides it
                return count if last_decrement <= ATTAINED * size else -1
        undamped = damping == 0.0
        damping = 0.25 * damping if damping > 1e-3 else 0.0
        energy, size = found, other
        for a in range(n):
            q[a] = trial[a]
            residual[a] = work.residual[a]
            step[a] = residual[a]
        fresh = False
        if undamped:
            solve_symmetric(work.matrix, step, n, width, work.solving)
            left = 0.0
            for a in range(n):
                left += layout.stiffness[a, a] * step[a] * step[a] if moments else step[a] * residual[a]
            left = abs(left)
            if left <= target or (decrement <= ROUNDING * size and left > 0.25 * decrement):
                return count
            fresh = left <= CONTRACTION * decrement and not moments
    return ITERATIONS if decrement <= 0.1 * ATTAINED * size and not moments else -1
