"""The same rod pulled by tension or by displacement: a change of drive does not move it."""

import numpy as np
import pytest

from tendond.model import Rod, RodParameters

TENSIONS = (12.0, 3.0, 0.0, 1.0)


@pytest.mark.parametrize("space", ["euler", "rk4", "rk6"])
def test_a_change_of_drive_at_rest_changes_nothing(space: str) -> None:
    rod = Rod(RodParameters(), space)
    rest = rod.solve_static(TENSIONS)
    pulled = rod.displacements(rest, elastic=True)
    driven = rod.step(rest, displacements=pulled)
    assert driven.displacement_driven
    np.testing.assert_allclose(rod.tip(driven).position, rod.tip(rest).position, atol=1e-8)
    np.testing.assert_allclose(driven.tensions, TENSIONS, atol=1e-5)
    back = rod.step(driven, TENSIONS)
    assert not back.displacement_driven
    np.testing.assert_allclose(rod.tip(back).position, rod.tip(rest).position, atol=1e-8)


def test_letting_go_of_pulled_tendons_slackens_them_at_once() -> None:
    rod = Rod(RodParameters())
    state = rod.step(rod.solve_static(displacements=(0.03, 0.0, -0.03, 0.0)), displacements=(0.03, 0.0, -0.03, 0.0))
    assert state.tensions[0] > 10.0
    free = rod.step(state, (0.0, 0.0, 0.0, 0.0))
    assert np.all(free.tensions == 0.0)
    assert free.marches < 60


def test_antagonists_can_be_taut_together_and_slack_ones_stay_slack() -> None:
    rod = Rod(RodParameters())
    taut = rod.solve_static(displacements=(0.001, 0.001, 0.001, 0.001)).tensions
    assert np.all(taut > 5.0)
    slack = rod.solve_static(displacements=(0.03, -0.01, -0.05, -0.01)).tensions
    assert slack[0] > 5.0
    assert np.all(slack[1:] == 0.0)
