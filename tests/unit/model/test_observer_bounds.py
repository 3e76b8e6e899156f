"""What the observer may pull with, and how the law in space takes errors away."""

import math

import numpy as np
import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.laws import sensitivity
from tendond.daemon.control.laws.law import Observation, Outlook
from tendond.daemon.control.state import CycleSetup, initial_state
from tendond.model.tendons.allocation import Allocation
from tendond.schemas.config.rig import parse_config
from tendond.schemas.config.robot import RodSection
from tendond.schemas.record import CycleInputs
from tests.unit.control.cycles import pose


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.6, 0.0, -0.8)])
def test_the_pull_on_the_model_is_bounded_by_four_times_the_largest_estimated_force(
    direction: tuple[float, ...],
) -> None:
    """A tip 0.2 m from the model's asks for newtons; 0.05 N are the largest force that may be estimated."""
    setup = CycleSetup.from_config(parse_config("[observer]\nforce_max = 0.05\n", "test"))
    state = initial_state(setup)
    away = tuple((state.tip.position + 0.2 * np.array(direction)).tolist())
    pulls = []
    for seq in range(1, 8):
        state, _, record = step(setup, state, CycleInputs(pose=pose(seq, away)))
        pulls.append(np.linalg.norm(record.observer.pull))
        assert np.linalg.norm(record.observer.force) <= 0.05 + 1e-12
    assert max(pulls) == pytest.approx(0.2)  # the bound is met


def test_the_law_in_space_lets_an_error_decay_at_two_rates_whatever_it_is_doing() -> None:
    """e(k+1) = (a + b) e(k) - a b e(k-1), a and b the decay of `rate` and of `smoothing` in a cycle."""
    parameters = sensitivity.Parameters()
    period, allocation = 0.01, Allocation(RodSection().tendon_positions, 1.0, 60.0)
    before, now = np.array([0.004, -0.002, 0.001]), np.array([0.003, 0.001, -0.002])
    ahead = np.array([0.3, 0.1, 0.2])
    zero = np.zeros(3)
    observation = Observation(
        position=zero,
        velocity=-(now - before) / period,
        acceleration=zero,
        input_gain=np.zeros((3, 4)),
        response=None,
        tension=np.full(4, 5.0),
        target=now,
        target_velocity=zero,
        target_acceleration=zero,
        axes=(0, 2),
        agonist=0,
        antagonist=None,
        input_gain_min=1.0,
        pair_tension=0.0,
        outlook=Outlook(period, ahead, np.eye(3)[:, :2], ahead, None, allocation),
    )
    a, b = (math.exp(-rate * period) for rate in (parameters.rate, parameters.smoothing))
    terms = sensitivity.decide(parameters, observation).terms
    assert isinstance(terms, sensitivity.Terms)
    assert terms.asked == pytest.approx(-((a + b) * now - a * b * before), abs=1e-15)
