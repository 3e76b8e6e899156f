"""A reference that the servos cannot follow in time says so, with figures that a hand can check."""

import math
import re

import pytest

from tendond.daemon.control.reference.feasibility import displacement_rate_max
from tendond.daemon.control.reference.planar import PlanarReference
from tendond.daemon.control.setup import CycleSetup
from tendond.schemas.config.presets import PROFILES, WIRED
from tendond.schemas.config.rig import parse_config


def planned(text: str) -> PlanarReference:
    config = parse_config(text, "test").with_own_rates()
    reference = CycleSetup.from_config(config).selection.reference
    assert isinstance(reference, PlanarReference)
    return reference


def test_the_papers_trajectory_is_too_fast_for_the_papers_servos_and_says_what_it_takes() -> None:
    reference = planned(PROFILES["rig"].replace('kind = "minimum_jerk"\nduration = 2.0', 'kind = "exponential"'))
    (said,) = reference.notes
    pace, rate, displacement, time_min = map(float, re.findall(r"(\d+(?:\.\d+)?) (?:mm|s)\b", said))
    assert (rate, displacement) == (85.0, 60.0)
    assert time_min == pytest.approx(0.0598 / 0.085, abs=0.01)
    assert 500.0 < pace < 1500.0  # 20 /s of 60 mm is 1200 mm/s


def test_a_minimum_jerk_trajectory_asks_for_less_than_twice_its_mean_speed() -> None:
    """Its peak is 15/8 of the mean, and the tendon's displacement grows with the tip's a little unevenly."""
    reference = planned(PROFILES["rig"])
    mean = 0.0598 / 2.0
    assert displacement_rate_max(reference.curve, reference.trajectory, reference.arrival) == pytest.approx(
        15.0 / 8.0 * mean, rel=0.3
    )
    assert reference.notes == ()


@pytest.mark.parametrize("text", [*PROFILES.values(), WIRED, ""])
def test_no_profile_is_late(text: str) -> None:
    reference = planned(text)
    assert reference.notes == ()


def test_a_step_is_faster_than_anything() -> None:
    reference = planned('[reference]\nkind = "step"\n[limits]\ndisplacement_rate = 0.1\n')
    assert displacement_rate_max(reference.curve, reference.trajectory, reference.arrival) == math.inf
    assert "at once" in reference.notes[0]
