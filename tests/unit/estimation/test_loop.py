"""The margin of the loop with the filter: poles, and the noise that it admits."""

import math

import numpy as np
import pytest

from tendond.daemon.control.gains import law_rates
from tendond.model.estimation.kalman.loop import SHARES, admitted_noise, design, filter_poles, noise_in_loop
from tendond.model.estimation.kalman.noise import noise_of
from tendond.model.estimation.poles import UnknownPlant
from tendond.model.rod.parameters import RodParameters
from tendond.schemas.config.rig import parse_config

ROD = RodParameters()
RATES = law_rates(parse_config("", "test"))
NOISE = noise_of(ROD, 1e-4, 2e-3, 0.1, 3.0, 0.1)
ARM = max(math.hypot(*place) for place in ROD.tendon_positions)


@pytest.mark.parametrize("delay", [0, 3])
def test_with_plant_equal_to_model_the_filters_own_poles_are_those_of_its_design(delay: int) -> None:
    """The separation principle: no delay that is known makes the loop unstable."""
    made = design(ROD, 0.01, NOISE, ARM)
    measured = np.zeros(len(made.step))
    measured[made.tip] = 1.0
    own = np.linalg.eigvals(made.step @ (np.eye(len(made.step)) - np.outer(made.gain, measured)))
    poles = filter_poles(ROD, 0.01, made, RATES, UnknownPlant(delay=delay), delay, ahead=True)
    for pole in own:
        assert np.min(np.abs(poles - pole)) < 1e-4  # those at zero are multiple
    assert np.abs(poles[0]) < 1.0


def test_a_camera_that_is_trusted_fully_loses_the_margin_and_the_admitted_noise_keeps_it() -> None:
    late = UnknownPlant(delay=4)
    sharp = design(ROD, 0.01, NOISE, ARM)
    assert np.abs(filter_poles(ROD, 0.01, sharp, RATES, late, 3, ahead=True)[0]) > 1.0
    admitted = admitted_noise(ROD, 0.01, NOISE, RATES, 0.03, 0.02, ARM)
    made = design(ROD, 0.01, admitted, ARM)
    for plant in (late, UnknownPlant(0.02, 1.15, delay=4), UnknownPlant(0.0, 0.85, delay=3)):
        for ahead in (False, True):
            assert np.abs(filter_poles(ROD, 0.01, made, RATES, plant, 3, ahead=ahead)[0]) < 1.0
    larger = noise_in_loop(NOISE, ROD, 2.0 * admitted.load_rate / NOISE.load_rate)
    assert admitted.load_rate == SHARES[0] * NOISE.load_rate or admitted.load_rate < larger.load_rate


def test_a_heavier_unknown_tip_admits_less_drift() -> None:
    shares = [admitted_noise(ROD, 0.01, NOISE, RATES, 0.02, mass, ARM).load_rate for mass in (0.0, 0.02, 0.1)]
    assert shares[0] >= shares[1] >= shares[2]
    assert shares[0] > shares[2]
