"""Motions of the strain rod: energy, frequencies, errors in time, and that no step fails however light the damping."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.model.strain import Body, Robot, Section, StrainRod, StrainState
from tendond.model.strain.composites import curvature_of_points
from tendond.model.strain.kinematics import empty_shape, find_shape
from tendond.offline.bench.general_rod.survey import Outcome, survey
from tests.unit.strain.robots import paper


def test_the_jacobians_of_all_points_are_derivatives_of_the_shape() -> None:
    rod = StrainRod(
        paper(bodies=(Body(0.5, 0.05, (1e-5, 2e-5, 1.5e-5), (0.01, 0.0, 0.02)), Body(0.2, 0.01)), torsion_modes=2)
    )
    layout, rng = rod.layout, np.random.default_rng(1)
    q = rng.normal(size=rod.modes) * np.where(layout.component < 3, 6.0, 0.01)
    shape, other = empty_shape(layout), empty_shape(layout)
    find_shape(layout, q, shape)
    force, curvature = rng.normal(size=shape.point.shape), np.zeros((rod.modes, rod.modes))
    curvature_of_points(layout, shape, force, rod._work, curvature)
    for mode, unit in enumerate(np.eye(rod.modes)):
        find_shape(layout, q + 1e-6 * unit, other)
        ahead, pulled = other.point.copy(), np.einsum("pin,pi->n", other.jacobian[:, :, : rod.modes], force)
        find_shape(layout, q - 1e-6 * unit, other)
        assert shape.jacobian[:, :, mode] == pytest.approx((ahead - other.point) / 2e-6, abs=1e-8)
        row = (pulled - np.einsum("pin,pi->n", other.jacobian[:, :, : rod.modes], force)) / 2e-6
        assert curvature[mode] == pytest.approx(row, abs=0.05 * np.abs(curvature).max())


def released(damping: float, time_step: float, tension: float) -> tuple[list[float], int, float]:
    """Energies in a free release, steps that had to be split, and energy that was stored [J]."""
    rod = StrainRod(paper(damping=damping, drag=0.0), time_step)
    state = rod.solve_static(rod.loads([tension, 0.0, 0.0, 0.0]))
    free = rod.loads()
    energies, split = [rod.energy(state)], 0
    for _ in range(min(250, round(1.0 / time_step))):
        state = rod.step(state, free)
        energies.append(rod.energy(state))
        split += state.steps - 1
    return energies, split, energies[0] - rod.energy(rod.solve_static(free))


@pytest.mark.parametrize("time_step", [0.0005, 0.005, 0.02])
@pytest.mark.parametrize("damping", [0.0, 1e-4, 8e-3])
def test_no_energy_appears_in_a_free_release_and_no_step_fails(damping: float, time_step: float) -> None:
    energies, _, stored = released(damping, time_step, 60.0)
    assert np.diff(energies).max() < 1e-7 * stored
    assert energies[-1] < energies[0]


def test_a_body_with_inertia_swings_as_one() -> None:
    """A rigid body far heavier than the wire: a physical pendulum on a clamped spring, by Rayleigh's quotient below."""
    mass, inertia, arm = 0.2, (4e-5, 4e-5, 1e-5), 0.03
    light = Section.round(0.3, 5e-4, 200e9, 7850.0, stretch_modes=0, bending_modes=4)
    rod = StrainRod(Robot((light,), (), (Body(0.3, mass, inertia, (0.0, 0.0, arm)),)))
    stiffness = light.bending_stiffness[1] / light.length * np.array([[12.0 / 0.3**2, -6.0 / 0.3], [-6.0 / 0.3, 4.0]])
    coupling = np.array([[mass, mass * arm], [mass * arm, inertia[1] + mass * arm**2]])
    squares = np.linalg.eigvals(np.linalg.solve(coupling, stiffness))
    found = rod.frequencies(rod.rest(), rod.loads())
    assert found[0] == pytest.approx(math.sqrt(squares.min()) / (2.0 * math.pi), rel=5e-3)


def test_a_swing_has_the_natural_frequency() -> None:
    rod = StrainRod(paper(damping=0.0, drag=0.0, gravity=(0.0, 0.0, 0.0)), 0.002)
    state = rod.solve_static(rod.loads(tip_force=(0.01, 0.0, 0.0)))
    tips = [rod.tip(state)[0][0]]
    for _ in range(1000):
        state = rod.step(state, rod.loads())
        tips.append(rod.tip(state)[0][0])
    crossings = [k + tips[k] / (tips[k] - tips[k + 1]) for k in range(1000) if tips[k] > 0.0 >= tips[k + 1]]
    frequency = (len(crossings) - 1) / (0.002 * (crossings[-1] - crossings[0]))
    assert frequency == pytest.approx(3.7209, rel=2e-3)


def stepped(tension: float, time_step: float) -> NDArray[np.float64]:
    rod = StrainRod(paper(), time_step)
    state, loads = rod.solve_static(rod.loads()), rod.loads([tension, 0.0, 0.0, 0.0])
    tips = []
    for _ in range(round(0.3 / time_step)):
        state = rod.step(state, loads)
        tips.append(rod.tip(state)[0])
    return np.array(tips)


@pytest.mark.parametrize(("tension", "bound"), [(43.0, 2e-3), (60.0, 3e-3)])
def test_a_step_of_tension_is_right_in_time_at_ten_milliseconds(tension: float, bound: float) -> None:
    """A load counts over the whole of its step; a lag of half a step costs the shooting rod 37 and 47 mm."""
    fine, coarse = stepped(tension, 2.5e-4), stepped(tension, 0.01)
    assert np.linalg.norm(coarse - fine[39::40], axis=1).max() < bound


def test_a_step_changes_nothing_of_a_rest_and_nothing_of_the_state_it_started_from() -> None:
    rod = StrainRod(paper())
    loads = rod.loads([20.0, 0.0, 0.0, 0.0])
    state = rod.solve_static(loads)
    before = state.strain.copy()
    after = rod.step(state, loads)
    assert rod.tip(after)[0] == pytest.approx(rod.tip(state)[0], abs=1e-9)
    assert np.array_equal(state.strain, before)
    again = rod.step(StrainState(before, np.zeros(rod.modes)), loads)
    assert np.array_equal(again.strain, after.strain)


def test_drawn_robots_and_loads_all_step() -> None:
    """Length, radius, material, damping, step and load at random: each draw runs, and stays within its length."""
    rng = np.random.default_rng(7)
    for _ in range(60):
        length = 10.0 ** rng.uniform(-1.3, 0.3)
        modulus, density = ((200e9, 7850.0), (60e9, 6450.0), (1e6, 1100.0))[rng.integers(3)]
        radius = length * 10.0 ** rng.uniform(-2.9, -2.2) * (4.0 if modulus < 1e8 else 1.0)
        plain = Section.round(length, radius, modulus, density)
        omega = 1.8751**2 * math.sqrt(plain.bending_stiffness[0] / (plain.mass_per_length * length**4))
        ratio = rng.choice([0.0, 0.005, 0.05, 0.1])
        section = Section.round(
            length, radius, modulus, density, bending_damping=(2.0 * ratio * plain.bending_stiffness[0] / omega,) * 3
        )
        rod = StrainRod(
            Robot((section,), gravity=(0.0, 0.0, 9.81 * rng.uniform(-1, 1))), 10.0 ** rng.uniform(-4.0, -1.7)
        )
        state = rod.rest()
        load = 10.0 * plain.bending_stiffness[0] / length**2 * rng.normal(size=3)
        for k in range(25):
            state = rod.step(state, rod.loads(tip_force=load if k < 12 else (0.0, 0.0, 0.0)))
        assert np.linalg.norm(rod.tip(state)[0]) < 1.2 * length


def test_a_survey_of_violent_loads_finds_no_step_without_a_solution_and_no_energy_that_appears() -> None:
    """A part of `tendond bench rod --survey`; among the draws are some that only the last resort solves."""
    outcomes: list[Outcome] = []
    assert survey(60, progress=outcomes.append) == []
    assert sum(outcome.damped for outcome in outcomes) > 0


def test_a_step_far_too_long_for_its_load_says_that_it_was_damped_and_gains_no_energy() -> None:
    rod = StrainRod(paper(damping=0.0, drag=0.0), 0.02)
    state, free = rod.rest(), rod.loads()
    for _ in range(6):
        state = rod.step(state, rod.loads(wrenches=[(0.5, (0.0, 0.0, 0.0), (3.0, 2.0, 3.0))]))
    energies, damped = [rod.energy(state)], state.damped
    for _ in range(20):
        state = rod.step(state, free)
        damped += state.damped
        energies.append(rod.energy(state))
    assert damped > 0
    assert np.diff(energies).max() < 1e-7 * energies[0]
