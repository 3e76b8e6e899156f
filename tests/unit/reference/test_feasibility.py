"""A reference that the servos cannot follow in time says so, with figures that a hand can check."""

import math
import re

import pytest

from tendond.daemon.control.reference.feasibility import fastest_winding, feasibility
from tendond.daemon.control.reference.planar import Reference
from tendond.daemon.control.state import CycleSetup
from tendond.schemas.config.presets import PROFILES, WIRED
from tendond.schemas.config.rig import RigConfig, parse_config


def setup(text: str) -> tuple[Reference, RigConfig]:
    config = parse_config(text, "test").with_own_rates()
    reference = CycleSetup.from_config(config).selection.reference
    assert isinstance(reference, Reference)
    return reference, config


def test_the_papers_course_is_too_fast_for_the_papers_servos_and_says_what_it_takes() -> None:
    reference, config = setup(PROFILES["rig"].replace('kind = "minimum_jerk"\nduration = 2.0', 'kind = "exponential"'))
    said = feasibility(reference, config.limits)
    pace, rate, way, least = map(float, re.findall(r"(\d+(?:\.\d+)?) (?:mm|s)\b", said))
    assert (rate, way) == (85.0, 60.0)
    assert least == pytest.approx(0.0598 / 0.085, abs=0.01)
    assert 500.0 < pace < 1500.0  # 20 /s of 60 mm is 1200 mm/s


def test_a_minimum_jerk_course_asks_for_less_than_twice_its_mean_speed() -> None:
    """Its peak is 15/8 of the mean, and the tendon's way grows with the tip's a little unevenly."""
    reference, config = setup(PROFILES["rig"])
    mean = 0.0598 / 2.0
    assert fastest_winding(reference) == pytest.approx(15.0 / 8.0 * mean, rel=0.3)
    assert feasibility(reference, config.limits) == ""


@pytest.mark.parametrize("text", [*PROFILES.values(), WIRED, ""])
def test_no_profile_is_late(text: str) -> None:
    reference, config = setup(text)
    assert feasibility(reference, config.limits) == ""


def test_a_step_is_faster_than_anything() -> None:
    reference, config = setup('[reference]\nkind = "step"\n[limits]\ndisplacement_rate = 0.1\n')
    assert fastest_winding(reference) == math.inf
    assert "at once" in feasibility(reference, config.limits)
