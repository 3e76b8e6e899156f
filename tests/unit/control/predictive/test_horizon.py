"""Steps and knots of a horizon."""

import numpy as np
import pytest

from tendond.daemon.control.predictive.horizon import Horizon


@pytest.mark.parametrize(
    ("length", "steps", "period"), [(0.3, 12, 0.01), (0.2, 12, 0.004), (0.5, 8, 0.02), (0.02, 12, 0.02)]
)
def test_the_first_step_is_a_cycle_and_the_last_ones_reach_the_horizons_end(
    length: float, steps: int, period: float
) -> None:
    horizon = Horizon.of(length, steps, steps, period)
    assert horizon.cycles[0] == 1
    assert horizon.steps <= steps
    assert list(horizon.cycles) == sorted(horizon.cycles)
    assert length - 1e-9 <= horizon.ends[-1] < 2.0 * length + period


def test_every_tension_is_a_mean_of_the_knots_beside_it() -> None:
    horizon = Horizon.of(0.3, 12, 5, 0.01)
    assert horizon.shares.shape == (12, 5)
    assert horizon.shares.sum(axis=1) == pytest.approx(np.ones(12))
    assert horizon.shares[0].tolist() == [1.0, 0.0, 0.0, 0.0, 0.0]


def test_a_plan_that_grows_evenly_is_shifted_along_itself() -> None:
    horizon = Horizon.of(0.3, 12, 6, 0.01)
    plan = np.stack([2.0 * horizon.times, -horizon.times], axis=1)
    shifted = horizon.shifted(plan)
    assert shifted[:-1] == pytest.approx(plan[:-1] + np.array([0.02, -0.01]))
    assert shifted[-1] == pytest.approx(plan[-1])
