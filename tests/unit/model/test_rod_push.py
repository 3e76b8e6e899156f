"""A push along the rod: as a cantilever's deflection under a load anywhere, by Timoshenko, Strength of Materials."""

import numpy as np
import pytest

from tendond.model import ParameterError, Rod
from tendond.model.solver.schemes import SCHEMES
from tests.unit.rod.rods import WEIGHTLESS

SMALL = 1e-3
"""Force of small deflections [N]."""


@pytest.mark.parametrize("space", list(SCHEMES))
@pytest.mark.parametrize("place", [0.3, 0.5, 0.8])
def test_the_tip_moves_as_a_cantilevers_does_under_a_load_at_that_place(space: str, place: float) -> None:
    """w = P a^2 (3 L - a) / (6 EI) for a point load; spread over +-5 %, within some parts in a hundred."""
    rod = Rod(WEIGHTLESS, space)
    rod.spread_push(place)
    state = rod.solve_static(np.zeros(4), push=(SMALL, 0.0, 0.0))
    length, a = WEIGHTLESS.length, place * WEIGHTLESS.length
    expected = SMALL * a**2 * (3.0 * length - a) / (6.0 * WEIGHTLESS.bending_stiffness)
    assert rod.tip(state).position[0] == pytest.approx(expected, rel=0.06 if space == "euler" else 0.03)


@pytest.mark.parametrize("space", list(SCHEMES))
def test_the_whole_force_arrives_at_the_clamped_base(space: str) -> None:
    """Agreement within half a percent: six nodes see a stretch of a tenth of the rod at a few places only."""
    rod = Rod(WEIGHTLESS, space)
    rod.spread_push(0.7)
    state = rod.solve_static(np.zeros(4), push=(0.0, 0.2, 0.0))
    np.testing.assert_allclose(state.unknowns[state.count % len(state.unknowns), :3], (0.0, 0.2, 0.0), atol=1e-3)


def test_without_a_push_its_place_makes_no_difference() -> None:
    rod, other = Rod(WEIGHTLESS), Rod(WEIGHTLESS)
    other.spread_push(0.4)
    pull = [3.0, 0.0, 0.0, 0.0]
    np.testing.assert_array_equal(
        rod.tip(rod.solve_static(pull)).position, other.tip(other.solve_static(pull)).position
    )


def test_a_push_off_the_rod_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"place = 1\.2 must lie in \[0, 1\]"):
        Rod(WEIGHTLESS).spread_push(1.2)
