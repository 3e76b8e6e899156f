"""Equilibria of a load, stable or not, as many as are found from many starts.

Newton's method on the gradient of the potential energy finds one equilibrium; multiplied by

    M(q) = product over the known ones of (1 / d(q, q_k)^2 + 1)

it no longer converges to those that are known (P. E. Farrell, A. Birkisson, S. W. Funke, "Deflation techniques for
finding distinct solutions of nonlinear partial differential equations", SIAM J. Sci. Comput. 37, 2015).
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ConvergenceError
from tendond.model.strain.analysis.potential import ITERATIONS, SETTLED, STRIDE, Equilibrium, Potential, solved
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.state import StrainState
from tendond.model.strain.stepping.scratch import Loads

Array = NDArray[np.float64]

SAME = 1e-4
"""Distance below which two shapes are one."""


def find_equilibria(
    rod: StrainRod, loads: Loads, starts: int = 24, seed: int = 0, given: Sequence[StrainState] = ()
) -> tuple[Equilibrium, ...]:
    """Return the equilibria that are found from many starts, the lowest energy first; not necessarily all there are.

    Args:
        rod: the robot.
        loads: dead loads and tensions.
        starts: drawn ones, each section bent by up to a turn in any direction. seed: of the draw.
        given: further starts.

    A robot that is the same about its axis has whole rings of equilibria, of which single ones are found.
    """
    statics, random = Potential(rod, loads), np.random.default_rng(seed)
    guesses = [rod.rest().strain, *(one.strain for one in given), *(_drawn(rod, random) for _ in range(starts))]
    found: list[Array] = []
    for guess in guesses:
        try:
            lowest = rod.solve_static(loads, StrainState(guess, np.zeros_like(guess))).strain
        except ConvergenceError:
            continue
        if all(statics.size(lowest - one) > SAME for one in found):
            found.append(lowest)
    for guess in guesses:
        while (another := _deflated(statics, guess, found)) is not None:
            found.append(another)
    return tuple(sorted((statics.equilibrium(q) for q in found), key=lambda one: one.energy))


def _drawn(rod: StrainRod, random: np.random.Generator) -> Array:
    layout = rod.layout
    q = np.zeros(len(layout.component))
    for first in sorted(set(layout.first.tolist())):
        length = float(layout.step[layout.first == first].sum())
        last = int(layout.last[layout.first == first][0])
        angle, bend = random.uniform(0.0, 2.0 * math.pi), random.uniform(0.0, 2.0 * math.pi) / length
        for mode in range(first, last):
            if layout.component[mode] <= 1:
                direction = math.cos(angle) if layout.component[mode] == 0 else math.sin(angle)
                q[mode] = bend * direction if layout.order[mode] == 0 else 0.3 * random.standard_normal() * bend
    return q


def _deflated(statics: Potential, guess: Array, known: Sequence[Array]) -> Array | None:
    """Newton's method away from the known equilibria; none where it does not settle."""
    q = guess.copy()
    for _ in range(ITERATIONS):
        gradient, _ = statics.gradient(q)
        try:
            change = -solved(statics.tangent(q), gradient)
        except np.linalg.LinAlgError:
            return None
        if not np.all(np.isfinite(change)):
            return None
        if statics.size(change) < SETTLED and statics.left(gradient) < SETTLED:
            return q if all(statics.size(q - one) > SAME for one in known) else None
        slope = np.zeros_like(q)  # of log M
        for one in known:
            away = q - one
            square = max(statics.size(away) ** 2, 1e-24)
            slope -= 2.0 * (statics.layout.stiffness @ away) / statics.unit / (square * square) / (1.0 / square + 1.0)
        turned = 1.0 - float(slope @ change)  # Sherman and Morrison
        change = change / turned if abs(turned) > 1e-12 else change
        q = q + change * min(1.0, STRIDE / max(statics.size(change), 1e-300))
    return None
