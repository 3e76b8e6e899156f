"""Equilibria of the strain rod against textbooks, the shooting rod, and a plain solver for any routing."""

import math

import numpy as np
import pytest

from tendond.model.errors import ParameterError
from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.rod import Rod
from tendond.model.strain import Body, Robot, Section, StrainRod, Tendon
from tests.reference.routing import Piece, solve_routing
from tests.unit.strain.robots import paper


@pytest.mark.parametrize(
    ("load", "deflection", "shortening"), [(1.0, 0.30172, 0.05643), (2.0, 0.49346, 0.16064), (5.0, 0.71379, 0.38763)]
)
def test_the_elastica_under_a_dead_load_at_the_tip(load: float, deflection: float, shortening: float) -> None:
    """Mattiasson, "Numerical results from large deflection beam and frame problems", IJNME 17 (1981)."""
    section = Section.round(1.0, 1e-3, 200e9, 7850.0, stretch_modes=0, bending_modes=6)
    rod = StrainRod(Robot((section,)))
    tip, _ = rod.tip(rod.solve_static(rod.loads(tip_force=(load * section.bending_stiffness[1], 0.0, 0.0))))
    assert tip[0] == pytest.approx(deflection, abs=2e-5)
    assert 1.0 - tip[2] == pytest.approx(shortening, abs=2e-5)


@pytest.mark.parametrize(("bias", "tip_mm"), [(4.0, (66.611, 494.027)), (20.0, (287.805, 363.179))])
def test_parallel_tendons_bend_to_constant_curvature_exactly(bias: float, tip_mm: tuple[float, float]) -> None:
    """Closed form: v3 = 1 - sum T / (EA), u = r dT / (EI)."""
    rod = StrainRod(paper(gravity=(0.0, 0.0, 0.0)))
    tip, _ = rod.tip(rod.solve_static(rod.loads([1.0 + bias, 1.0, 1.0, 1.0])))
    assert 1e3 * tip[[0, 2]] == pytest.approx(tip_mm, abs=2e-3)


def test_the_curved_cantilever_of_bathe_and_bolourchi_bends_out_of_its_plane() -> None:
    """45 degrees of a circle of 100 in, 1 in square, E = 1e7 psi, 600 lb (IJNME 14, 1979).

    Published tips: 15.9, 47.2, 53.4 in; Simo & Vu-Quoc 15.79, 47.23, 53.37; Cardona & Geradin 15.55, 47.04, 53.50.
    """
    arc = 100.0 * math.pi / 4.0
    section = Section(
        arc, (1e7 / 12.0, 1e7 / 12.0), 5e6 / 6.0, 1e7, 1.0, 1.0, curvature=(0.0, 0.01, 0.0), bending_modes=6,
        torsion_modes=4, stretch_modes=1,
    )  # fmt: skip
    rod = StrainRod(Robot((section,)))
    state = rod.rest()
    for load in np.linspace(60.0, 600.0, 10):
        state = rod.solve_static(rod.loads(tip_force=(0.0, load, 0.0)), state)
    in_plane, out_of_plane, along = rod.tip(state)[0]
    assert (in_plane, along, out_of_plane) == pytest.approx((15.6, 47.0, 53.5), rel=7e-3)


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


THREE = Tendon(0.1, (0.008, 0.0)), Tendon(0.18, (-0.004, 0.007)), Tendon(0.242, (-0.004, -0.007))
HELICAL, CONVERGING = Tendon.helical(0.242, 0.008, 0.5), Tendon.converging(0.242, (0.01, 0.0), (0.004, 0.003))


@pytest.mark.parametrize(
    ("tendons", "tensions", "force"),
    [
        ((CONVERGING,), (4.0,), (0.0, 0.0, 0.0)),
        ((HELICAL,), (3.0,), (0.0, 0.0, 0.0)),
        ((HELICAL, CONVERGING), (2.0, 3.0), (0.1, 0.05, 0.02)),
        (THREE, (4.0, 2.0, 3.0), (0.0, 0.1, 0.0)),
    ],
    ids=["converging", "helical", "both with a load", "ends of three sections"],
)  # fmt: skip
def test_any_routing_bends_the_rod_as_the_balance_of_a_cut_says(
    tendons: tuple[Tendon, ...], tensions: tuple[float, ...], force: tuple[float, float, float]
) -> None:
    """The robot of Rucker and Webster (2011): L 242 mm, radius 0.4 mm, E 210 GPa, tendons 8 mm off the axis."""
    ends = sorted({tendon.end for tendon in tendons} | {0.242})
    lengths = np.diff([0.0, *ends])
    sections = tuple(
        Section.round(float(length), 4e-4, 210e9, 7850.0, bending_modes=8, torsion_modes=6, stretch_modes=4)
        for length in lengths
    )
    rod = StrainRod(Robot(sections, tendons))
    state = rod.rest()
    for part in np.linspace(0.25, 1.0, 4):
        state = rod.solve_static(rod.loads(part * np.array(tensions), tip_force=part * np.array(force)), state)
    tip, turn = rod.tip(state)
    one = sections[0]
    pieces = [
        Piece(float(length), (*one.bending_stiffness, one.torsion_stiffness), one.axial_stiffness) for length in lengths
    ]
    expected, orientation = solve_routing(
        pieces, [(tension, tendon.end, tendon.at) for tension, tendon in zip(tensions, tendons, strict=True)], force,
        guess=tip,
    )  # fmt: skip
    assert np.linalg.norm(tip - expected) < 1e-5 * 0.242
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
    wound = rod.displacements(by_tension) + np.array([10.0 / 2e4, 0.0, 0.0, 0.0])
    wound[1:] -= 1e-3
    by_displacement = rod.solve_static(rod.loads(displacement=wound))
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
def test_loads_that_cannot_be_are_refused(change: dict[str, object], said: str) -> None:
    rod = StrainRod(paper())
    with pytest.raises(ParameterError, match=said):
        rod.loads(**change)  # type: ignore[arg-type]


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
def test_robots_that_cannot_be_are_refused(robot: object, said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        robot()  # type: ignore[operator]
