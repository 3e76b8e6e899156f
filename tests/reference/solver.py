"""Shooting: the n(0), m(0) with which a sweep meets the tip condition, in statics and in a time step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tests.reference.equations import Loads
from tests.reference.rod import Array, ReferenceRod
from tests.reference.roots import NoRootError, find_root
from tests.reference.schemes import Scheme
from tests.reference.solution import Solution
from tests.reference.sweep import sweep

RESIDUAL_AIM = 1e-12
"""Polish until no component of the tip residual [N, N m] exceeds this."""
RESIDUAL_LIMIT = 1e-11
"""Never return a solution with more."""
SMALLEST_FRACTION = 1e-4
"""Continuation gives up below this fraction of the way to the loads asked for."""

ZERO = np.zeros(3)


def base_load_scale(rod: ReferenceRod, loads: Loads) -> Array:
    """Size of n(0) [N] and m(0) [N m], shape (6,): bending over the whole length, or what the loads bring."""
    EI = rod.Kbt[0, 0]
    force = max(EI / rod.length**2, float(np.sum(np.abs(loads.tensions))), float(np.linalg.norm(loads.tip_force_world)))
    return np.array([force] * 3 + [EI / rod.length] * 3)


def continued(solve: Callable[[float, Array], Array], guess: Array, first: float) -> Array:
    """solve(1, near) by way of fractions from `first` on, each near the last; steps halve where no root is found."""
    done, step, trail = 0.0, first, [(0.0, guess)]
    while done < 1.0:
        fraction = min(1.0, done + step)
        (f0, x0), (f1, x1) = trail[-2:] if len(trail) > 1 else (trail[0], trail[0])
        ahead = x1 if f1 == f0 else x1 + (x1 - x0) * (fraction - f1) / (f1 - f0)
        try:
            trail.append((fraction, solve(fraction, ahead)))
        except NoRootError:
            step /= 2.0
            if step < SMALLEST_FRACTION:
                raise
        else:
            done, step = fraction, 1.5 * step
    return trail[-1][1]


@dataclass(frozen=True, eq=False)
class ReferenceModel:
    """A rod in a space scheme. External loads are in the world frame, shape (3,); tensions [N] shape (n,)."""

    rod: ReferenceRod
    scheme: Scheme

    def loads(
        self,
        tensions: Array,
        tip_force_world: Array = ZERO,
        tip_moment_world: Array = ZERO,
        distributed_force_world: Array = ZERO,
        distributed_moment_world: Array = ZERO,
    ) -> Loads:
        """Loads [N, N m, N/m, N] with the rod's own gravity."""
        return Loads(
            np.asarray(tensions, dtype=np.float64),
            self.rod.gravity,
            np.asarray(tip_force_world, dtype=np.float64),
            np.asarray(tip_moment_world, dtype=np.float64),
            np.asarray(distributed_force_world, dtype=np.float64),
            np.asarray(distributed_moment_world, dtype=np.float64),
        )

    @property
    def no_history(self) -> Array:
        """y_h of statics: zero, shape (P, 6, 3)."""
        return np.zeros((self.scheme.points, 6, 3))

    def shoot(self, loads: Loads, c0: float, y_h: Array, guess: Array) -> Array:
        """n(0), m(0), shape (6,), near the guess; raises NoRootError."""
        return find_root(
            lambda base_load: sweep(self.rod, self.scheme, loads, c0, y_h, base_load).residual,
            guess,
            base_load_scale(self.rod, loads),
            RESIDUAL_AIM,
            RESIDUAL_LIMIT,
        )

    def static_solution(self, loads: Loads, base_load: Array) -> Solution:
        """The static shape with this base load, at rest: both past steps equal, derivatives zero."""
        swept = sweep(self.rod, self.scheme, loads, 0.0, self.no_history, base_load)
        return Solution(self.rod, self.scheme, loads, base_load, swept, y_previous=swept.y, y_t=swept.y_t)

    def step_solution(self, previous: Solution, loads: Loads, base_load: Array) -> Solution:
        """The end of the time step with this base load."""
        swept = sweep(self.rod, self.scheme, loads, self.rod.c0, previous.history, base_load)
        return Solution(self.rod, self.scheme, loads, base_load, swept, y_previous=previous.sweep.y, y_t=swept.y_t)

    def solve_static(
        self,
        tensions: Array,
        tip_force_world: Array = ZERO,
        tip_moment_world: Array = ZERO,
        distributed_force_world: Array = ZERO,
        distributed_moment_world: Array = ZERO,
        start: Solution | None = None,
    ) -> Solution:
        """The static shape under these loads, at rest.

        All loads grow together from those of `start`, or from none: the shape is the one that the rod is led to, and
        not another one of the several that a strongly bent rod may have.
        """
        loads = self.loads(
            tensions, tip_force_world, tip_moment_world, distributed_force_world, distributed_moment_world
        )
        origin = start.loads if start else Loads(0.0 * loads.tensions, ZERO)
        guess = start.base_load if start else np.zeros(6)

        def solve(fraction: float, near: Array) -> Array:
            return self.shoot(origin.blend(loads, fraction), 0.0, self.no_history, near)

        return self.static_solution(loads, continued(solve, guess, first=0.25))

    def step(
        self,
        previous: Solution,
        tensions: Array,
        tip_force_world: Array = ZERO,
        tip_moment_world: Array = ZERO,
        distributed_force_world: Array = ZERO,
        distributed_moment_world: Array = ZERO,
    ) -> Solution:
        """One time step dt later, under these loads at its end; `previous` is a static solution or a step."""
        loads = self.loads(
            tensions, tip_force_world, tip_moment_world, distributed_force_world, distributed_moment_world
        )

        def solve(fraction: float, near: Array) -> Array:
            return self.shoot(previous.loads.blend(loads, fraction), self.rod.c0, previous.history, near)

        return self.step_solution(previous, loads, continued(solve, previous.base_load, first=1.0))
