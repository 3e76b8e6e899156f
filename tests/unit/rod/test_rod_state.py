"""A state is a value: no step changes it, be it solved or not, and put aside it goes on bit for bit."""

import io
import pickle
from dataclasses import fields, replace

import numpy as np
import pytest

from tendond.model import ConvergenceError, ParameterError, Rod, RodState
from tendond.model.solver.schemes import SCHEMES
from tests.unit.rod.rods import PAPER, Array, identical, last_state, one_tendon

UNDAMPED = replace(PAPER, bending_damping=(0.0, 0.0, 0.0))

each_space = pytest.mark.parametrize("space", list(SCHEMES))


def unsolvable(space: str) -> tuple[Rod, RodState, Array]:
    """A rod that shooting cannot solve, a state of it, and a jump of the tension.

    Undamped, with dt 0.1 ms: an error of the base load grows towards the tip by exp(L (c0^2 rho A / 4EI)^(1/4)), 1e15.
    """
    coarse = Rod(UNDAMPED, space, time_step=0.01)
    rod = Rod(UNDAMPED, space, time_step=0.0001)
    state = coarse.step(coarse.solve_static(one_tendon(5.0)), one_tendon(6.0))
    return rod, state, one_tendon(60.0)


@each_space
def test_a_step_that_cannot_be_solved_says_so_and_leaves_the_state(space: str) -> None:
    rod, state, jump = unsolvable(space)
    untouched = pickle.loads(pickle.dumps(state))
    with pytest.raises(ConvergenceError, match=r"a time step did not converge at t = 0\.0101 s: residual") as failure:
        rod.step(state, jump)
    assert failure.value.time == pytest.approx(state.time + rod.time_step)
    assert not failure.value.residual <= 1e-6
    assert failure.value.iterations > 0
    assert all(np.array_equal(getattr(state, field.name), getattr(untouched, field.name)) for field in fields(state))
    solvable = Rod(UNDAMPED, space, time_step=0.01)
    assert identical(solvable.step(state, one_tendon(7.0)), solvable.step(untouched, one_tendon(7.0)))


@each_space
def test_an_advance_that_fails_leaves_all_but_the_carried_jacobian(space: str) -> None:
    rod, state, jump = unsolvable(space)
    untouched = state.copy()
    with pytest.raises(ConvergenceError):
        rod.advance(state, rod.loads(jump))
    assert identical(state, untouched)
    untouched.jacobian[:] = state.jacobian
    solvable = Rod(UNDAMPED, space, time_step=0.01)
    for tension in (7.0, 8.0, 9.0):
        for each in (state, untouched):
            solvable.advance(each, solvable.loads(one_tendon(tension)))
    assert identical(state, untouched)


@each_space
def test_an_advance_that_fails_to_change_the_drive_leaves_it(space: str) -> None:
    rod, state, _ = unsolvable(space)
    untouched = state.copy()
    with pytest.raises(ConvergenceError):
        rod.advance(state, rod.loads([0.05, 0.0, -0.05, 0.0]), displacement_driven=True)
    assert identical(state, untouched)


def test_a_state_of_another_rod_is_refused() -> None:
    """Its arrays are longer than the rod's here; were they shorter, the kernels would write beyond them."""
    state = Rod(PAPER, "rk6", nodes=7).solve_static()
    with pytest.raises(ParameterError):
        Rod(PAPER, "rk6", nodes=6).step(state)


def test_statics_that_cannot_be_solved_says_so() -> None:
    with pytest.raises(ConvergenceError, match="statics did not converge at t = 0 s") as failure:
        Rod(PAPER, tolerance=1e-16).solve_static(one_tendon(20.0))
    assert failure.value.time == 0.0
    assert failure.value.iterations > 0


def moving(rod: Rod) -> RodState:
    """A state in the middle of a motion."""
    state = rod.solve_static()
    for step in range(12):
        state = rod.step(state, one_tendon(5.0 * step, step % 3))
    return state


def through_npz(state: RodState) -> RodState:
    """Saved to a file of arrays and loaded from it."""
    file = io.BytesIO()
    np.savez(file, **{field.name: getattr(state, field.name) for field in fields(state)})
    file.seek(0)
    with np.load(file) as saved:
        return RodState(**{name: value if value.ndim else value.item() for name, value in saved.items()})


@each_space
def test_a_state_that_was_put_aside_goes_on_bit_for_bit(space: str) -> None:
    rod = Rod(PAPER, space)
    state = moving(rod)
    others = [state.copy(), pickle.loads(pickle.dumps(state)), through_npz(state)]
    assert all(identical(other, state) for other in others)
    for step in range(12):
        state = rod.step(state, one_tendon(40.0 - step, step % 2))
        others = [rod.step(other, one_tendon(40.0 - step, step % 2)) for other in others]
        assert all(identical(other, state) for other in others)


def test_a_rods_scratch_memory_does_not_leak_from_state_to_state() -> None:
    alone, shared = Rod(PAPER), Rod(PAPER)
    mine, others = alone.solve_static(), shared.solve_static()
    disturbing = moving(shared)
    for step in range(6):
        mine, others = alone.step(mine, one_tendon(5.0 * step)), shared.step(others, one_tendon(5.0 * step))
        disturbing = shared.step(disturbing, one_tendon(30.0, 3))
        shared.sensitivity(disturbing)
        shared.tip(disturbing)
    assert identical(mine, others)


def test_a_step_leaves_the_state_that_it_starts_from() -> None:
    rod = Rod(PAPER)
    state = moving(rod)
    before = {name: array.copy() for name, array in last_state(state).items()}
    rod.step(state, one_tendon(20.0))
    rod.sensitivity(state)
    rod.tip(state)
    assert all(np.array_equal(array, before[name]) for name, array in last_state(state).items())
