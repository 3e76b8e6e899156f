"""The rod is solved under large loads and sudden ones, in every time step from 1 to 20 ms."""

import numpy as np
import pytest

from tendond.model import ConvergenceError, Rod, RodState
from tendond.model.solver.schemes import SCHEMES
from tests.unit.rod.rods import PAPER, WEIGHTLESS, one_tendon

GRAVITY = 9.81
TIME_STEPS = [0.001, 0.002, 0.005, 0.01, 0.02]

each_space = pytest.mark.parametrize("space", list(SCHEMES))
each_time_step = pytest.mark.parametrize("dt", TIME_STEPS)


def assert_in_reach(rod: Rod, state: RodState) -> None:
    """Solved, and nowhere farther from the base than the rod is long; Euler's R grows by u^2 ds L / 2, 4 % at 60 N."""
    assert state.residual <= 1e-6
    assert np.max(np.linalg.norm(state.shape, axis=1)) < (1.05 if rod.scheme.order == 1 else 1.001) * PAPER.length


@each_space
def test_statics_bends_the_straight_rod_by_60_newtons_at_once(space: str) -> None:
    rod = Rod(PAPER, space)
    for tendon in range(4):
        assert_in_reach(rod, rod.solve_static(one_tendon(60.0, tendon)))


@each_space
def test_statics_bends_the_straight_rod_by_180_degrees_at_once(space: str) -> None:
    """An arc of u L = pi has its tip at 2 / u beside the base."""
    rod = Rod(WEIGHTLESS, space)
    EI, L = PAPER.youngs_modulus * PAPER.second_moment, PAPER.length
    tip = rod.tip(rod.solve_static(one_tendon(np.pi * EI / L / 0.02)))
    scheme_error = 0.02 if SCHEMES[space].order == 1 else 1e-3
    assert tip.position == pytest.approx([2.0 * L / np.pi, 0.0, 0.0], abs=scheme_error * L)
    assert tip.rotation[2, 2] == pytest.approx(-1.0, abs=2.0 * scheme_error)


@each_space
@pytest.mark.parametrize("tendon", range(4))
def test_statics_carries_50_to_200_grams_at_the_tip(space: str, tendon: int) -> None:
    rod = Rod(PAPER, space)
    for mass in (0.05, 0.1, 0.15, 0.2):
        for tension in (0.0, 5.0, 20.0, 43.0, 60.0):
            load = (-GRAVITY * mass, 0.0, 0.0)
            assert_in_reach(rod, rod.solve_static(one_tendon(tension, tendon), tip_force=load))


@pytest.mark.parametrize("space", ["rk4", "rk6"])
def test_200_grams_against_the_tendon_snap_through_and_a_motion_follows(space: str) -> None:
    """Loading by the tendon ends at a fold near 39 N, unloading at one near 36 N: between them, two shapes are at rest.

    Statics cannot be led past a fold, and says so. The rod itself jumps, and time steps go with it.
    """
    rod, load = Rod(PAPER, space, nodes=13), (-GRAVITY * 0.2, 0.0, 0.0)
    upright = rod.solve_static(one_tendon(38.0), tip_force=load)
    folded = rod.solve_static(one_tendon(38.0), tip_force=load, start=rod.solve_static(one_tendon(60.0)))
    assert rod.tip(upright).position[2] > 0.4
    assert rod.tip(folded).position[2] < 0.0
    with pytest.raises(ConvergenceError):
        rod.solve_static(one_tendon(41.0), tip_force=load, start=upright)
    state = upright
    for _ in range(200):
        state = rod.step(state, one_tendon(41.0), tip_force=load)
    beyond = rod.solve_static(one_tendon(41.0), tip_force=load, start=folded)
    assert rod.tip(rod.solve_static(one_tendon(41.0), tip_force=load)).position == pytest.approx(
        rod.tip(beyond).position
    )
    assert rod.tip(state).position == pytest.approx(rod.tip(beyond).position, abs=1e-4)


@each_space
@each_time_step
def test_a_bent_rod_takes_a_blow_of_10_newtons_from_any_side(space: str, dt: float) -> None:
    rod, tensions = Rod(PAPER, space, time_step=dt), [20.0, 10.0, 0.0, 0.0]
    bent = rod.solve_static(tensions)
    for direction in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1), (0.6, -0.6, 0.53)):
        state = rod.step(bent, tensions, tip_force=[10.0 * component for component in direction])
        for _ in range(30):
            state = rod.step(state, tensions)
            assert_in_reach(rod, state)


@each_space
@each_time_step
def test_a_tendon_takes_and_loses_60_newtons_within_one_step(space: str, dt: float) -> None:
    rod = Rod(PAPER, space, time_step=dt)
    for tendon in (0, 1):
        state = rod.solve_static()
        for tension in (60.0, 0.0, 60.0, 0.0):
            for _ in range(max(5, round(0.1 / dt))):
                state = rod.step(state, one_tendon(tension, tendon))
                assert_in_reach(rod, state)


@each_space
@each_time_step
def test_60_newtons_go_round_the_tendons_from_step_to_step(space: str, dt: float) -> None:
    rod = Rod(PAPER, space, time_step=dt)
    state = rod.solve_static()
    for step in range(40):
        state = rod.step(state, one_tendon(60.0, step % 4))
        assert_in_reach(rod, state)


@each_space
@each_time_step
def test_tendons_are_pulled_and_paid_out_by_20_mm_within_one_step(space: str, dt: float) -> None:
    rod = Rod(PAPER, space, time_step=dt)
    state = rod.solve_static(displacements=np.zeros(4))
    for tendon in (0, 1, 2, 3):
        commands = np.full(4, -0.02)
        commands[tendon] = 0.02
        for _ in range(max(3, round(0.05 / dt))):
            state = rod.step(state, displacements=commands)
            assert_in_reach(rod, state)
            assert np.min(state.tensions) > -1e-6  # a tendon cannot push, beyond the solver's tolerance


@each_space
@each_time_step
def test_the_papers_rod_comes_to_rest_in_every_time_step(space: str, dt: float) -> None:
    rod = Rod(PAPER, space, time_step=dt)
    tensions = one_tendon(43.0)
    state = rod.step(rod.solve_static(tensions), tensions, tip_force=(0.0, 1.0, 0.0))
    while state.time < 1.5:
        state = rod.step(state, tensions)
    assert rod.tip(state).position == pytest.approx(rod.tip(rod.solve_static(tensions)).position, abs=1e-5)


@each_space
@pytest.mark.parametrize("commands", [[-0.02, 0.0, 0.02, 0.0], [0.02, 0.0, -0.02, 0.0]])
@pytest.mark.parametrize("dt", [0.005, 0.02])
def test_a_rod_goes_over_from_tension_to_displacement_as_if_it_had_been_pulled_so_before(
    space: str, commands: list[float], dt: float
) -> None:
    rod = Rod(PAPER, space, time_step=dt)
    by_tension = rod.solve_static(one_tendon(43.0))
    held = np.where(by_tension.tensions > 0.0, rod.displacements(by_tension, elastic=True), -0.1)
    by_displacement = rod.solve_static(displacements=held)
    expected = rod.tip(rod.step(by_displacement, displacements=commands)).position
    assert rod.tip(rod.step(by_tension, displacements=commands)).position == pytest.approx(expected, abs=1e-6)
