"""The rod at rest is what textbooks say: arc, elastica, beam, compression; and it is the same from every side."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tendond.model import Rod
from tests.unit.rod.rods import PAPER, WEIGHTLESS, Array, External, one_tendon, relative

EA = PAPER.youngs_modulus * PAPER.area
EI = PAPER.youngs_modulus * PAPER.second_moment


@pytest.mark.parametrize(("difference", "tip_x", "tip_z"), [(4.0, "66.611", "494.027"), (20.0, "287.805", "363.179")])
def test_parallel_tendons_bend_a_weightless_rod_to_an_arc(difference: float, tip_x: str, tip_z: str) -> None:
    """Rucker & Webster 2011, section V: v3 = 1 - sum T / EA, u = r dT / EI, all along the rod, exactly.

    Runge-Kutta of order 6 in 60 steps has a truncation error near 1e-12; the solver leaves 1e-11 N m of u's EI = 0.15.
    """
    rod = Rod(WEIGHTLESS, "rk6", nodes=61, tolerance=1e-11)
    tensions = np.ones(4) + one_tendon(difference)
    v3, u = 1.0 - tensions.sum() / EA, 0.02 * difference / EI
    s = np.linspace(0.0, PAPER.length, rod.nodes)
    arc = np.column_stack([v3 / u * (1.0 - np.cos(u * s)), 0.0 * s, v3 / u * np.sin(u * s)])
    state = rod.solve_static(tensions)
    assert np.max(np.abs(state.shape - arc)) < 1e-10
    assert (f"{1e3 * arc[-1, 0]:.3f}", f"{1e3 * arc[-1, 2]:.3f}") == (tip_x, tip_z)
    turned = u * PAPER.length
    across = [[math.cos(turned), 0.0, math.sin(turned)], [0.0, 1.0, 0.0], [-math.sin(turned), 0.0, math.cos(turned)]]
    assert rod.tip(state).rotation == pytest.approx(np.array(across), abs=1e-9)
    shortening = PAPER.length * (1.0 - (v3 - u * np.array([0.02, 0.0, -0.02, 0.0])))
    assert rod.displacements(state) == pytest.approx(shortening, abs=1e-12)


@pytest.mark.parametrize(
    ("load", "across", "along"),
    [(1.0, "0.30172", "0.05643"), (2.0, "0.49346", "0.16064"), (5.0, "0.71379", "0.38763")],
)
def test_a_load_across_the_tip_bends_a_slender_rod_to_the_elastica(load: float, across: str, along: str) -> None:
    """Bisshopp & Drucker 1945; Timoshenko & Gere, Mechanics of Materials: w/L and 1 - x/L by P L^2 / EI.

    A rod 2500 times as long as it is thick: shear and stretch, of the order of EI / (EA L^2) = 1e-8, do not show.
    """
    slender = replace(WEIGHTLESS, length=5.0)
    rod = Rod(slender, "rk6", nodes=31, tolerance=1e-10)
    tip = rod.tip(rod.solve_static(tip_force=(load * EI / slender.length**2, 0.0, 0.0))).position
    assert (f"{tip[0] / slender.length:.5f}", f"{1.0 - tip[2] / slender.length:.5f}") == (across, along)


def test_a_moment_at_the_tip_bends_the_rod_to_an_arc_and_a_twisting_one_twists_it_evenly() -> None:
    """Euler-Bernoulli and Saint-Venant: u1 = M / EI, u3 = M / GJ."""
    rod = Rod(WEIGHTLESS, "rk6", nodes=61, tolerance=1e-11)
    bent = rod.tip(rod.solve_static(tip_moment=(0.3, 0.0, 0.0)))
    angle = 0.3 / EI * PAPER.length
    radius = EI / 0.3
    assert bent.position == pytest.approx([0.0, -radius * (1.0 - math.cos(angle)), radius * math.sin(angle)], abs=1e-10)
    twisted = rod.tip(rod.solve_static(tip_moment=(0.0, 0.0, 0.1))).rotation
    angle = 0.1 / (PAPER.shear_modulus * 2.0 * PAPER.second_moment) * PAPER.length
    assert twisted[:2, 0] == pytest.approx([math.cos(angle), math.sin(angle)], abs=1e-10)


def test_equal_tensions_on_all_tendons_only_compress() -> None:
    """Hooke: v3 = 1 - sum T / EA; the strain's rounding, 1e-16, is all that may be seen."""
    rod = Rod(WEIGHTLESS, tolerance=1e-11)
    state = rod.solve_static([25.0, 25.0, 25.0, 25.0])
    v3 = 1.0 - 100.0 / EA
    assert np.max(np.abs(state.shape[:, :2])) < 1e-10
    assert rod.tip(state).position[2] == pytest.approx(v3 * PAPER.length, abs=1e-15)
    assert rod.displacements(state) == pytest.approx(np.full(4, (1.0 - v3) * PAPER.length), abs=1e-13)


def test_small_loads_bend_the_rod_as_a_linear_beam() -> None:
    """Gere & Timoshenko, beam deflections: P L^3 / 3EI with a load at the tip, w L^4 / 8EI along it; and of shear."""
    rod = Rod(WEIGHTLESS, "rk6", nodes=31, tolerance=1e-11)
    GA, L = PAPER.shear_modulus * PAPER.area, PAPER.length
    point = rod.tip(rod.solve_static(tip_force=(1e-4, 0.0, 0.0))).position[0]
    along = rod.tip(rod.solve_static(distributed_force=(0.0, 1e-4, 0.0))).position[1]
    # the rest is of second order in the slope, here 1e-4
    assert point == pytest.approx(1e-4 * (L**3 / (3.0 * EI) + L / GA), rel=1e-7)
    assert along == pytest.approx(1e-4 * (L**4 / (8.0 * EI) + L**2 / (2.0 * GA)), rel=1e-7)


@pytest.mark.parametrize("space", ["euler", "rk4", "rk6"])
def test_a_problem_turned_by_90_degrees_about_the_rod_has_the_turned_answer(space: str) -> None:
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    across = replace(PAPER, gravity=(0.0, -9.81, 0.0))
    force, moment = np.array([0.2, -0.1, 0.1]), np.array([0.02, 0.01, -0.03])
    tensions = np.array([20.0, 8.0, 1.0, 3.0])

    def motion(rod: Rod, tensions: Array, turned: Array) -> list[Array]:
        loads = External(tip_force=(turned @ force).tolist(), tip_moment=(turned @ moment).tolist())
        state = rod.solve_static(0.3 * tensions, **loads)
        quantities = [state.shape @ turned]
        for _ in range(5):
            state = rod.step(state, tensions, **loads)
            tip = rod.tip(state)
            quantities += [state.shape @ turned, turned.T @ tip.velocity, turned.T @ tip.acceleration]
        return quantities

    straight = motion(Rod(PAPER, space, tolerance=1e-11), tensions, np.eye(3))
    turned = motion(Rod(across, space, tolerance=1e-11), np.roll(tensions, 1), turn)
    assert max(relative(a, b) for a, b in zip(turned, straight, strict=True)) < 1e-9
