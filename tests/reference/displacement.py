"""The rod pulled by tendon displacements: T_i = max(0, k_i (commanded_i - d_i)), solved together with n(0), m(0).

d_i = L - path length of tendon i along the rod; k_i [N/m] is all that gives between the winch and the tip, such as
EA / L_t. Which tendons are taut is settled by trial: with a given set the system is smooth; then the tendon of lowest
index that disagrees (taut with T < 0, or slack and displaced by less than its command) changes sides, as in Murty's
least-index method for linear complementarity problems, which never cycles.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.reference.equations import Loads
from tests.reference.rod import Array, ReferenceRod
from tests.reference.roots import NoRootError, find_root
from tests.reference.solution import Solution
from tests.reference.solver import RESIDUAL_AIM, ZERO, ReferenceModel, base_load_scale, continued
from tests.reference.sweep import sweep

TENDON_LIMIT = 1e-10
"""Largest residual of a returned solution: rod [N, N m], tendons [N] once divided by the bending compliance."""


def bending_compliance(rod: ReferenceRod) -> float:
    """About how far one newton moves a tendon [m/N]: L r^2 / EI."""
    return float(rod.length * np.max(np.sum(rod.tendon_positions**2, axis=1)) / rod.Kbt[0, 0])


def shoot_with(
    model: ReferenceModel,
    loads: Loads,
    c0: float,
    y_h: Array,
    commands: Array,
    stiffnesses: Array,
    taut: list[int],
    guess: Array,
) -> tuple[Array, Array]:
    """n(0), m(0), T, shape (6 + n,), with the tendons in `taut` as linear springs of either sign and no tension in the
    others, and the displacements d, shape (n,). The tensions in `loads` are not used. Raises NoRootError.
    """
    compliance = bending_compliance(model.rod)
    unknowns = [*range(6), *(6 + index for index in taut)]

    def at(x: Array) -> tuple[Array, Array]:
        tensions = np.zeros(len(commands))
        tensions[taut] = x[6:]
        swept = sweep(model.rod, model.scheme, replace(loads, tensions=tensions), c0, y_h, x[:6])
        displacements = model.rod.length - swept.path_lengths
        springs = (tensions / stiffnesses - (commands - displacements)) / compliance
        return np.concatenate([swept.residual, springs[taut]]), displacements

    scale = np.full(6 + len(commands), base_load_scale(model.rod, replace(loads, tensions=commands / compliance))[0])
    scale[3:6] = model.rod.Kbt[0, 0] / model.rod.length
    x = find_root(lambda unknown: at(unknown)[0], guess[unknowns], scale[unknowns], RESIDUAL_AIM, TENDON_LIMIT)
    solved = np.zeros(6 + len(commands))
    solved[unknowns] = x
    return solved, at(x)[1]


def shoot_displacements(
    model: ReferenceModel, loads: Loads, c0: float, y_h: Array, commands: Array, stiffnesses: Array, guess: Array
) -> Array:
    """n(0), m(0), T, shape (6 + n,), near the guess; raises NoRootError."""
    taut = guess[6:] > 0.0
    for _ in range(2 ** len(commands)):
        guess, displacements = shoot_with(
            model, loads, c0, y_h, commands, stiffnesses, [int(index) for index in np.flatnonzero(taut)], guess
        )
        wrong = np.where(taut, guess[6:] < 0.0, commands - displacements > 0.0)
        if not wrong.any():
            return guess
        first = int(np.argmax(wrong))
        taut[first] = not taut[first]
    raise NoRootError("no set of taut tendons agrees with the shape that it gives")


def pulled_from(solution: Solution, stiffnesses: Array) -> Array:
    """The commands [m], shape (n,), that hold a solution as it is."""
    return np.asarray(solution.tendon_displacements + solution.tensions / stiffnesses)


def solve_static_displacements(
    model: ReferenceModel,
    commands: Array,
    stiffnesses: Array,
    tip_force_world: Array = ZERO,
    tip_moment_world: Array = ZERO,
    distributed_force_world: Array = ZERO,
    distributed_moment_world: Array = ZERO,
    start: Solution | None = None,
) -> Solution:
    """The static shape with these commands [m] and stiffnesses [N/m], shape (n,), at rest.

    Commands and loads grow together from those of `start`, or from none.
    """
    commands, stiffnesses = np.asarray(commands, dtype=np.float64), np.asarray(stiffnesses, dtype=np.float64)
    loads = model.loads(
        np.zeros(len(commands)), tip_force_world, tip_moment_world, distributed_force_world, distributed_moment_world
    )
    origin = start.loads if start else Loads(0.0 * commands, ZERO)
    origin_commands = pulled_from(start, stiffnesses) if start else 0.0 * commands
    guess = np.concatenate([start.base_load, start.tensions]) if start else np.zeros(6 + len(commands))

    def solve(fraction: float, near: Array) -> Array:
        pulled = (1.0 - fraction) * origin_commands + fraction * commands
        blended = origin.blend(loads, fraction)
        return shoot_displacements(model, blended, 0.0, model.no_history, pulled, stiffnesses, near)

    x = continued(solve, guess, first=0.25)
    return model.static_solution(replace(loads, tensions=x[6:]), x[:6])


def step_displacements(
    model: ReferenceModel,
    previous: Solution,
    commands: Array,
    stiffnesses: Array,
    tip_force_world: Array = ZERO,
    tip_moment_world: Array = ZERO,
    distributed_force_world: Array = ZERO,
    distributed_moment_world: Array = ZERO,
) -> Solution:
    """One time step dt later, with these commands [m] and stiffnesses [N/m], shape (n,), and loads at its end."""
    commands, stiffnesses = np.asarray(commands, dtype=np.float64), np.asarray(stiffnesses, dtype=np.float64)
    loads = model.loads(
        np.zeros(len(commands)), tip_force_world, tip_moment_world, distributed_force_world, distributed_moment_world
    )
    origin_commands = pulled_from(previous, stiffnesses)

    def solve(fraction: float, near: Array) -> Array:
        pulled = (1.0 - fraction) * origin_commands + fraction * commands
        blended = previous.loads.blend(loads, fraction)
        return shoot_displacements(model, blended, model.rod.c0, previous.history, pulled, stiffnesses, near)

    x = continued(solve, np.concatenate([previous.base_load, previous.tensions]), first=1.0)
    return model.step_solution(previous, replace(loads, tensions=x[6:]), x[:6])
