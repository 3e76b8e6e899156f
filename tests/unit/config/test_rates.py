"""Rates of tension and displacement: the robot's own where none are named, no step of all the tension in a cycle."""

import itertools
import math

import numpy as np
import pytest

from tendond.daemon.control.setup import CycleSetup
from tendond.drivers.simulator.lockstep import closed_loop, without_probe
from tendond.schemas.config.presets import PAPER
from tendond.schemas.config.rates import natural_frequency, own_displacement_rate, own_tension_rate
from tendond.schemas.config.rig import parse_config
from tendond.schemas.config.robot import RodSection
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction


def test_the_first_natural_frequency_is_that_of_a_steel_ruler_in_the_textbook() -> None:
    """A clamped round steel rod of 1 m and 10 mm: 3.516/(2 pi) sqrt(EI/(rho A L^4)) = 7.07 Hz (Blevins, table 8-1)."""
    rod = RodSection(length=1.0, radius=0.005, youngs_modulus=200e9, density=7850.0)
    assert natural_frequency(rod) / (2.0 * math.pi) == pytest.approx(7.06, abs=0.02)


def test_the_rates_are_twice_a_right_angle_in_a_quarter_of_the_first_period() -> None:
    rod = RodSection()
    quarter = 0.5 * math.pi / natural_frequency(rod)
    stiffness = rod.youngs_modulus * math.pi / 4.0 * rod.radius**4
    right_angle = stiffness * (math.pi / 2.0) / (rod.length * 0.02)
    assert own_tension_rate(rod) == pytest.approx(2.0 * right_angle / quarter)
    assert own_displacement_rate(rod) == pytest.approx(4.0 * 0.02 * (math.pi / 2.0) / quarter)


@pytest.mark.parametrize("law", ["backstepping", "sliding_mode", "sensitivity"])
@pytest.mark.parametrize("period", [0.01, 0.002])
def test_without_limits_the_tension_changes_at_the_robots_own_rate(law: str, period: float) -> None:
    config = without_probe(parse_config(f"[loop]\nperiod = {period}\n[control]\nlaw = '{law}'\n", "test"))
    records = list(closed_loop(config, round(1.5 / period), {5: ControlAction.ARM}))
    tensions = [np.array(record.command.tension) for record in records]
    steps = [float(np.max(np.abs(b - a))) for a, b in itertools.pairwise(tensions)]
    assert max(steps) <= own_tension_rate(config.rod) * period + 1e-9
    assert max(steps) < 0.12 * config.limits.tension_max
    assert records[-1].mode is Mode.TRACKING
    assert records[-1].measured is not None
    assert math.dist(records[-1].measured, records[-1].reference.target) < 2e-3


def test_rates_that_are_named_win() -> None:
    limits = CycleSetup.from_config(parse_config("[limits]\ntension_rate = 50.0\n", "test")).config.limits
    assert limits.tension_rate == 50.0
    assert limits.displacement_rate == pytest.approx(1.870, abs=0.001)


def test_the_papers_simulation_has_the_rates_of_the_paper() -> None:
    limits = CycleSetup.from_config(parse_config(PAPER, "paper")).config.limits
    assert (limits.tension_rate, limits.displacement_rate) == (6000.0, 5.0)


def test_a_command_that_leads_a_lag_may_change_by_as_much_more_as_the_lead_asks_for() -> None:
    plain = parse_config("", "plain").with_own_rates().limits
    with_lag = parse_config("[observer]\nlag = 0.0448\n", "lag").with_own_rates().limits  # a fifth of a step in a cycle
    assert with_lag.tension_rate == pytest.approx(5.0 * plain.tension_rate, rel=0.01)
    assert with_lag.displacement_rate == pytest.approx(5.0 * plain.displacement_rate, rel=0.01)
    named = parse_config("[observer]\nlag = 0.0448\n[limits]\ntension_rate = 100.0\n", "named").with_own_rates().limits
    assert named.tension_rate == 100.0
