"""The paper's robot as the general rod and as the converged shooting rod: the same to 1e-4 of the length.

The cases are those of the paper: rests over its tensions, with gravity in every direction; where steps of tension end;
loads on the tip; releases; tendons that are driven by displacement.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.rod import Rod
from tendond.model.rod.state import RodState
from tendond.model.strain import StrainRod, StrainState
from tests.unit.strain.robots import paper

Array = NDArray[np.float64]
Triple = tuple[float, float, float]

LENGTH = 0.5
BOUND = 1e-4 * LENGTH
SETTLED = 3.0
"""Time in which what is left of the first mode is below 1e-5: it decays by exp(-0.63 2 pi 3.7 t) [s]."""

DIRECTIONS = {
    f"{sign}{axis}": tuple(9.81 * float(f"{sign}1") * (axis == one) for one in "xyz") for axis in "xyz" for sign in "+-"
}


@cache
def shooting_rod(gravity: Triple = (-9.81, 0.0, 0.0)) -> Rod:
    return Rod(replace(RodParameters(), gravity=gravity), "rk6", 41, 0.01)


@cache
def general_rod(gravity: Triple = (-9.81, 0.0, 0.0)) -> StrainRod:
    return StrainRod(paper(gravity=gravity, bending_modes=5), 0.01)


def shooting_rest(rod: Rod, tensions: Array, force: Triple = (0.0, 0.0, 0.0)) -> RodState:
    """Follow the load from nothing: the shooting rod needs a start that is near."""
    state = rod.solve_static(np.zeros(4))
    for part in np.linspace(0.05, 1.0, 20):
        state = rod.solve_static(part * tensions, tip_force=part * np.array(force), start=state)
    return state


def general_rest(rod: StrainRod, tensions: Array, force: Triple = (0.0, 0.0, 0.0)) -> StrainState:
    state = rod.rest()
    for part in np.linspace(0.05, 1.0, 20):
        state = rod.solve_static(rod.loads(part * tensions, tip_force=part * np.array(force)), state)
    return state


def assert_same(general: StrainRod, ours: StrainState, shooting: Rod, theirs: RodState) -> None:
    assert np.linalg.norm(general.tip(ours)[0] - shooting.tip(theirs).position) < BOUND
    assert general.displacements(ours) == pytest.approx(shooting.displacements(theirs), abs=BOUND)


@pytest.mark.parametrize("gravity", DIRECTIONS.values(), ids=DIRECTIONS)
@pytest.mark.parametrize("tension", [0.0, 5.0, 20.0, 43.0, 60.0])
def test_rests_are_the_same_over_the_papers_tensions_with_gravity_from_all_sides(
    tension: float, gravity: Triple
) -> None:
    tensions = np.array([tension, 0.1 * tension, 0.0, 0.0])
    general, shooting = general_rod(gravity), shooting_rod(gravity)
    assert_same(general, general_rest(general, tensions), shooting, shooting_rest(shooting, tensions))


@pytest.mark.parametrize("force", [(0.3, 0.0, 0.0), (0.0, 0.5, 0.0), (0.0, 0.0, -0.4), (-0.2, 0.3, 0.5)])
@pytest.mark.parametrize("tension", [0.0, 20.0])
def test_rests_are_the_same_under_forces_on_the_tip(tension: float, force: Triple) -> None:
    tensions = np.array([tension, 0.0, 0.0, 0.0])
    general, shooting = general_rod(), shooting_rod()
    assert_same(general, general_rest(general, tensions, force), shooting, shooting_rest(shooting, tensions, force))


@pytest.mark.parametrize(("before", "after"), [(0.0, 43.0), (0.0, 60.0), (43.0, 0.0), (60.0, 0.0)])
def test_steps_of_tension_and_releases_end_in_the_same_shape(before: float, after: float) -> None:
    general, shooting = general_rod(), shooting_rod()
    start, end = np.array([before, 0.0, 0.0, 0.0]), np.array([after, 0.0, 0.0, 0.0])
    ours, theirs = general_rest(general, start), shooting_rest(shooting, start)
    loads = general.loads(end)
    for _ in range(round(SETTLED / 0.01)):
        ours, theirs = general.step(ours, loads), shooting.step(theirs, end)
    assert_same(general, ours, shooting, theirs)


def test_tendons_driven_by_displacement_end_in_the_same_shape() -> None:
    general, shooting = general_rod(), shooting_rod()
    ours, theirs = general_rest(general, np.zeros(4)), shooting_rest(shooting, np.zeros(4))
    pulled = np.array([0.03, 0.004, -0.04, -0.04])  # the last two are slack
    for part in [*np.linspace(0.02, 1.0, 50), *np.ones(round(SETTLED / 0.01))]:
        ours = general.step(ours, general.loads(displacement=part * pulled))
        theirs = shooting.step(theirs, displacements=part * pulled)
    assert_same(general, ours, shooting, theirs)
