"""Loads along the backbone, at stations, by tension and displacement together, and wrenches that follow."""

import math

import numpy as np
import pytest

from tendond.model.errors import ParameterError
from tendond.model.strain import Robot, Section, StrainRod
from tendond.model.strain.derivatives.follower import Followers
from tests.unit.strain.robots import paper

NONE = (0.0, 0.0, 0.0)


def test_a_uniform_load_along_the_backbone_is_the_robots_own_weight_turned() -> None:
    weightless = StrainRod(paper(gravity=NONE))
    heavy = StrainRod(paper(gravity=(-9.81, 0.0, 0.0)))
    weight = np.array([-9.81 * heavy.robot.sections[0].mass_per_length, 0.0, 0.0])
    spread = weightless.loads([4.0, 0.0, 0.0, 1.0], distributed=[(0.0, 0.5, weight, NONE)])
    expected = heavy.tip(heavy.solve_static(heavy.loads([4.0, 0.0, 0.0, 1.0])))[0]
    assert weightless.tip(weightless.solve_static(spread))[0] == pytest.approx(expected, abs=1e-9)


def test_a_load_on_a_part_of_the_backbone_bends_it_as_the_beam_formula_says() -> None:
    """Uniform load w from a to the tip: deflection there w (3 L^4 - 4 a^3 L + a^4) / (24 EI) (Roark, table 8.1)."""
    section = Section.round(1.0, 1e-3, 200e9, 7850.0, bending_modes=6, stretch_modes=0)
    rod, start = StrainRod(Robot((section,))), 0.37
    load = 1e-4 * section.bending_stiffness[1]
    tip, _ = rod.tip(rod.solve_static(rod.loads(distributed=[(start, 1.0, (load, 0.0, 0.0), NONE)])))
    assert tip[0] == pytest.approx(1e-4 * (3.0 - 4.0 * start**3 + start**4) / 24.0, rel=1e-5)


def test_a_station_takes_a_wrench_between_the_nodes() -> None:
    """A transverse force at a: tip deflection F a^2 (3 L - a) / (6 EI)."""
    section = Section.round(1.0, 1e-3, 200e9, 7850.0, bending_modes=6, stretch_modes=0)
    rod, at = StrainRod(Robot((section,)), stations=(0.4321,)), 0.4321
    force = 1e-4 * section.bending_stiffness[1]
    tip, _ = rod.tip(rod.solve_static(rod.loads(wrenches=[(at, (force, 0.0, 0.0), NONE)])))
    assert tip[0] == pytest.approx(1e-4 * at**2 * (3.0 - at) / 6.0, rel=2e-4)


def test_some_tendons_pull_by_tension_and_others_by_displacement_in_one_call() -> None:
    rod = StrainRod(paper())
    by_tension = rod.solve_static(rod.loads([10.0, 0.0, 0.0, 2.0]))
    pulled = rod.displacements(by_tension)[0] + 10.0 / 2e4
    mixed = rod.loads([None, 0.0, 0.0, 2.0], [pulled, None, None, None])
    assert mixed.driven.tolist() == [True, False, False, False]
    assert rod.tip(rod.solve_static(mixed))[0] == pytest.approx(rod.tip(by_tension)[0], abs=1e-7)
    for tension, displacement in (([1.0, 0.0, 0.0, None], [0.01, None, None, None]), ([None, 0.0, 0.0, 0.0], None)):
        with pytest.raises(ParameterError, match="needs a tension or a displacement"):
            rod.loads(tension, displacement)


def test_a_follower_moment_at_the_tip_closes_a_circle() -> None:
    section = Section.round(1.0, 1e-3, 200e9, 7850.0, stretch_modes=0)
    rod = StrainRod(Robot((section,)))
    turned = Followers(rod, [(1.0, NONE, (0.0, 2.0 * math.pi * section.bending_stiffness[1], 0.0))])
    tip, turn = rod.tip(turned.solve_static(rod.loads()))
    assert tip == pytest.approx(np.zeros(3), abs=1e-6)
    assert turn == pytest.approx(np.eye(3), abs=1e-6)


def test_a_follower_of_a_step_acts_in_the_cross_section_and_rests_where_statics_says() -> None:
    rod = StrainRod(paper(gravity=NONE), 0.02)
    pushed = Followers(rod, [(0.5, (1.5, 0.0, 0.0), NONE)])
    expected = rod.tip(pushed.solve_static(rod.loads()))[0]
    state = rod.rest()
    for _ in range(150):
        state = rod.step(state, pushed.loads(state, rod.loads()))
    assert rod.tip(state)[0] == pytest.approx(expected, abs=2e-5)  # it still settles
    _, point = rod.node(0.5)
    force = pushed.loads(state, rod.loads(), ahead=0.0).force[point]
    assert rod.tip(state)[1].T @ force == pytest.approx((1.5, 0.0, 0.0), abs=1e-3)


@pytest.mark.parametrize(
    ("span", "said"), [((0.1, 0.7), "must lie on the backbone"), ((0.3, 0.2), "must lie on the backbone")]
)
def test_a_load_beside_the_backbone_is_refused(span: tuple[float, float], said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        StrainRod(paper()).loads(distributed=[(*span, (1.0, 0.0, 0.0), NONE)])


def test_a_follower_that_is_not_finite_is_refused() -> None:
    with pytest.raises(ParameterError, match="three finite numbers"):
        Followers(StrainRod(paper()), [(0.5, (math.nan, 0.0, 0.0), NONE)])
