"""The paper's scheme (forward Euler, N = 200, dt 0.01 s) gives the figures of an independent implementation.

The equations and the robot are those of Danesh & Janabi-Sharifi, "Backstepping Control of Tendon-Driven Continuum
Robots in Large Deflections Using the Cosserat Rod Model", arXiv:2412.12035 (2024), sections 2 and 3 and table 1. The
command `python -m tests.reference.check` prints the figures beside those of its own implementation, which shares no
code with the kernels.
"""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from tendond.model import Rod, RodState
from tests.unit.rod.rods import PAPER, WEIGHTLESS, one_tendon

UNEQUAL = (5.0, 4.0, 1.0, 1.0)


@pytest.mark.parametrize(
    ("tension", "x", "z", "shortened"),
    [(10.0, "0.1607", "0.4639", "13.41"), (43.0, "0.3447", "0.0456", "57.67")],
)
def test_one_tendon_bends_the_weightless_rod_in_its_plane(tension: float, x: str, z: str, shortened: str) -> None:
    rod = Rod(WEIGHTLESS, "euler")
    state = rod.solve_static(one_tendon(tension))
    position = rod.tip(state).position
    assert (f"{position[0]:.4f}", f"{position[2]:.4f}") == (x, z)
    assert abs(position[1]) < 1e-12  # nothing acts out of the plane
    assert f"{1e3 * rod.displacements(state)[0]:.2f}" == shortened


def test_the_unloaded_rod_sags_by_28_mm() -> None:
    rod = Rod(PAPER, "euler")
    assert f"{1e3 * rod.tip(rod.solve_static()).position[0]:.2f}" == "-27.94"


@pytest.mark.parametrize(
    ("nodes", "x"), [(50, "36.60"), (100, "37.84"), (200, "38.45"), (400, "38.76"), (800, "38.91")]
)
def test_euler_comes_near_the_limit_of_39_mm_slowly(nodes: int, x: str) -> None:
    rod = Rod(PAPER, "euler", nodes=nodes)
    assert f"{1e3 * rod.tip(rod.solve_static(UNEQUAL)).position[0]:.2f}" == x


def test_the_limit_of_39_mm_is_what_richardson_makes_of_euler_and_what_runge_kutta_gives() -> None:
    coarse, fine = (Rod(PAPER, "euler", nodes=nodes) for nodes in (401, 801))
    first_order = (
        2.0 * fine.tip(fine.solve_static(UNEQUAL)).position - coarse.tip(coarse.solve_static(UNEQUAL)).position
    )
    accurate = Rod(PAPER)
    assert f"{1e3 * first_order[0]:.2f}" == "39.06"
    assert f"{1e3 * accurate.tip(accurate.solve_static(UNEQUAL)).position[0]:.2f}" == "39.06"


@pytest.mark.parametrize(("difference", "off"), [(4.0, "0.34"), (20.0, "1.69")])
def test_euler_is_off_the_arc_by_a_first_order_error(difference: float, off: str) -> None:
    rod = Rod(WEIGHTLESS, "euler")
    tensions = np.ones(4) + one_tendon(difference)
    u = 0.02 * difference / (PAPER.youngs_modulus * PAPER.second_moment)
    v3 = 1.0 - tensions.sum() / (PAPER.youngs_modulus * PAPER.area)
    arc = v3 / u * np.array([1.0 - math.cos(u * PAPER.length), 0.0, math.sin(u * PAPER.length)])
    assert f"{1e3 * np.linalg.norm(rod.tip(rod.solve_static(tensions)).position - arc):.2f}" == off


def test_43_newtons_at_once_swing_the_rod_past_its_equilibrium() -> None:
    rod, tensions = Rod(PAPER, "euler"), one_tendon(43.0)
    state = rod.solve_static()
    x = []
    for _ in range(100):
        state = rod.step(state, tensions)
        x.append(rod.tip(state).position[0])
    assert (f"{x[2]:.4f}", f"{x[10]:.4f}") == ("0.0828", "0.3611")
    rest = rod.solve_static(tensions)
    for settled in (state, rest):
        assert rod.tip(settled).position[0] == pytest.approx(0.3440, abs=0.5001e-4)
        assert f"{1e3 * rod.displacements(settled)[0]:.2f}" == "57.48"


def test_340_mm_is_reached_twice_and_passed_by_362_mm_in_between() -> None:
    """The figures of the less bent shape are this scheme's; converged: 266 and 36.9 mm."""
    rod = Rod(PAPER, "euler")

    def pulled(tension: float) -> RodState:
        return rod.solve_static(one_tendon(tension))

    def beyond(tension: float) -> float:
        return float(rod.tip(pulled(tension)).position[0]) - 0.340

    farthest = max(beyond(tension) for tension in np.arange(34.0, 38.0, 0.25)) + 0.340
    less_bent, more_bent = brentq(beyond, 20.0, 36.0), brentq(beyond, 36.0, 46.0)
    assert f"{1e3 * farthest:.0f}" == "362"
    assert f"{1e3 * rod.tip(pulled(less_bent)).position[2]:.0f}" == "269"
    assert f"{1e3 * rod.displacements(pulled(less_bent))[0]:.1f}" == "36.8"
    assert f"{more_bent:.1f}" == "43.8"
    assert f"{1e3 * rod.tip(pulled(more_bent)).position[2]:.0f}" == "40"
    assert f"{1e3 * rod.displacements(pulled(more_bent))[0]:.1f}" == "58.6"


def test_a_tendons_elastic_stretch_adds_to_its_displacement() -> None:
    rod = Rod(WEIGHTLESS, "euler")
    state = rod.solve_static(one_tendon(10.0))
    stretch = rod.displacements(state, elastic=True) - rod.displacements(state)
    assert stretch == pytest.approx([10.0 / PAPER.tendon_stiffness, 0.0, 0.0, 0.0], abs=1e-15)
