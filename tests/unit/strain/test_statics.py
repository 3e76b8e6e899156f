"""Equilibria of the strain rod against textbooks, the shooting rod, and a plain solver for any routing."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tendond.model.errors import ParameterError
from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.rod import Rod
from tendond.model.strain import Body, Robot, Section, StrainRod, Tendon
from tendond.offline.bench.general_rod import textbooks
from tests.reference.routing import Piece, solve_routing
from tests.unit.strain.robots import paper


@pytest.mark.parametrize(("load", "deflection", "shortening"), textbooks.ELASTICA)
def test_the_elastica_under_a_dead_load_at_the_tip(load: float, deflection: float, shortening: float) -> None:
    assert textbooks.elastica_tip(load) == pytest.approx((deflection, shortening), abs=2e-5)


@pytest.mark.parametrize(("bias", "tip_mm"), [(4.0, (66.611, 494.027)), (20.0, (287.805, 363.179))])
def test_parallel_tendons_bend_to_constant_curvature_exactly(bias: float, tip_mm: tuple[float, float]) -> None:
    """Closed form: v3 = 1 - sum T / (EA), u = r dT / (EI)."""
    rod = StrainRod(paper(gravity=(0.0, 0.0, 0.0)))
    tip, _ = rod.tip(rod.solve_static(rod.loads([1.0 + bias, 1.0, 1.0, 1.0])))
    assert 1e3 * tip[[0, 2]] == pytest.approx(tip_mm, abs=2e-3)


def test_the_curved_cantilever_of_bathe_and_bolourchi_bends_out_of_its_plane() -> None:
    """Agreement within the published spread, see `bend_tip`."""
    assert textbooks.bend_tip() == pytest.approx((15.6, 47.0, 53.5), rel=7e-3)


@pytest.mark.parametrize(
    "tensions", [(0.0, 0.0, 0.0, 0.0), (10.0, 0.0, 0.0, 0.0), (43.0, 0.0, 0.0, 0.0), (5.0, 4.0, 1.0, 1.0)]
)
def test_the_shooting_rod_finds_the_same_rest(tensions: tuple[float, ...]) -> None:
    shooting = Rod(RodParameters(), "rk6", 41, 0.01)
    state = shooting.solve_static(np.zeros(4))
    for part in np.linspace(0.1, 1.0, 10):
        state = shooting.solve_static(part * np.array(tensions), start=state)
    rod = StrainRod(paper(torsion_modes=4, bending_modes=5))
    ours = rod.solve_static(rod.loads(tensions))
    assert np.linalg.norm(rod.tip(ours)[0] - shooting.tip(state).position) < 1e-5 * 0.5
    assert rod.displacements(ours) == pytest.approx(shooting.displacements(state), abs=2e-6)


@pytest.mark.parametrize("case", textbooks.ROUTED.values(), ids=textbooks.ROUTED)
def test_any_routing_bends_the_rod_as_the_balance_of_a_cut_says(case: textbooks.Routed) -> None:
    (tip, turn), (expected, orientation) = textbooks.routed_tips(case, solve_routing, Piece)
    assert np.linalg.norm(tip - expected) < 1e-5 * textbooks.REACH
    assert turn == pytest.approx(orientation, abs=1e-4)


def test_what_was_loaded_beyond_its_critical_load_rests_in_a_stable_shape() -> None:
    """Euler's column: at P = 1.5 times pi^2 EI / (4 L^2) the straight rod is an equilibrium, but no rest."""
    section = Section.round(0.5, 1e-3, 190e9, 7850.0)
    rod = StrainRod(Robot((section,)))
    critical = math.pi**2 * section.bending_stiffness[0] / (4.0 * 0.5**2)
    below, above = (rod.loads(tip_force=(0.0, 0.0, -part * critical)) for part in (0.98, 1.5))
    assert rod.stability(rod.rest(), below) > 0.0 > rod.stability(rod.rest(), above)
    nudged = rod.solve_static(rod.loads(tip_force=(1e-3 * critical, 0.0, -1.5 * critical)))
    bent = rod.solve_static(above, nudged)
    assert rod.tip(bent)[0][0] > 0.1
    assert rod.stability(bent, above) > 0.0


def test_natural_frequencies_are_those_of_the_cantilever_with_and_without_a_mass_on_its_tip() -> None:
    """Blevins, Formulas for Natural Frequency and Mode Shape (1979), tables 8-1 and 8-8."""
    rod = StrainRod(paper(gravity=(0.0, 0.0, 0.0), bending_modes=7))
    found = rod.frequencies(rod.rest(), rod.loads())
    assert found[[0, 2, 4]] == pytest.approx((3.7209, 23.319, 65.293), rel=1e-3)
    section = rod.robot.sections[0]
    mass = section.mass_per_length * section.length
    loaded = StrainRod(paper(gravity=(0.0, 0.0, 0.0), bodies=(Body(0.5, mass),)))
    first = 1.2479**2 / (2.0 * math.pi) * math.sqrt(section.bending_stiffness[0] / (mass * section.length**3))
    assert loaded.frequencies(loaded.rest(), loaded.loads())[0] == pytest.approx(first, rel=1e-3)


def test_a_tendon_driven_by_displacement_pulls_as_its_stretch_says_and_never_pushes() -> None:
    rod = StrainRod(paper())
    by_tension = rod.solve_static(rod.loads([10.0, 0.0, 0.0, 0.0]))
    displacement = rod.displacements(by_tension) + np.array([10.0 / 2e4, 0.0, 0.0, 0.0])
    displacement[1:] -= 1e-3
    by_displacement = rod.solve_static(rod.loads(displacement=displacement))
    assert rod.tip(by_displacement)[0] == pytest.approx(rod.tip(by_tension)[0], abs=1e-7)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"tension": (1.0, 1.0, 1.0)}, "4 finite numbers"),
        ({"tension": (-1.0, 0.0, 0.0, 0.0)}, "cannot push"),
        ({"tension": (math.nan, 0.0, 0.0, 0.0)}, "4 finite numbers"),
        ({"tip_force": (math.inf, 0.0, 0.0)}, "tip_force"),
        ({"wrenches": [(0.123, (1.0, 0.0, 0.0), (0.0, 0.0, 0.0))]}, "no node at s = 0.123 m"),
    ],
)
def test_loads_that_cannot_be_are_refused(change: dict[str, Any], said: str) -> None:
    rod = StrainRod(paper())
    with pytest.raises(ParameterError, match=said):
        rod.loads(**change)


@pytest.mark.parametrize(
    ("robot", "said"),
    [
        (lambda: Robot(()), "sections is empty"),
        (lambda: Robot((Section.round(0.1, 1e-3, 1e9, 1e3),), (Tendon(0.2, (0.01, 0.0)),)), "must lie on the backbone"),
        (lambda: Section.round(-0.1, 1e-3, 1e9, 1e3), "length = -0.1"),
        (lambda: Section.round(0.1, 0.0, 1e9, 1e3), "radius = 0.0"),
        (lambda: Body(0.1, 1.0, (1.0, 1.0, 9.0)).points(), "is not that of any body"),
        (lambda: Robot((Section.round(0.1, 1e-3, 1e9, 1e3),), base=np.ones((3, 3))), "not a rotation matrix"),
    ],
)
def test_robots_that_cannot_be_are_refused(robot: Callable[[], object], said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        robot()
