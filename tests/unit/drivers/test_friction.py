"""Friction of the simulated tendons, against the capstan equation by hand and the textbook's bent rod."""

import math
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tendond.drivers.simulator.friction import TendonMiddles, between, grip
from tendond.model import RodParameters
from tendond.offline.bench.friction import (
    COEFFICIENTS,
    FARTHEST,
    HEADING,
    STEPS,
    FrictionLoop,
    pull_and_release,
    run_rig,
)

ROD = RodParameters()
ARM = 0.02
STIFFNESS = 2e4
DOCS = Path(__file__).parents[3] / "docs" / "simulator.md"


@cache
def loop(coefficient: float) -> FrictionLoop:
    return pull_and_release(coefficient, STIFFNESS)


def by_hand(behind: float, coefficient: float, *, winding: bool) -> tuple[float, float]:
    """End [m] and tension [N] of a servo whose tendon pulls the rod with `behind` [N].

    The rod is a circular arc: bend phi = T r L/(EI), and its path shortens by L (T/(EA) + r phi/L). Half of the tendon
    stretches by the tension behind the middle of the path, half by the capstan's before it.
    """
    bend = behind * ARM * ROD.length / ROD.bending_stiffness
    shortening = ROD.length * behind / (ROD.youngs_modulus * ROD.area) + ARM * bend
    before = behind * math.exp((0.5 if winding else -0.5) * coefficient * bend)
    return shortening + 0.5 * (behind + before) / STIFFNESS, before


@pytest.mark.parametrize("coefficient", [0.1, 0.2])
@pytest.mark.parametrize("behind", [8.0, 20.0, 35.0])
@pytest.mark.parametrize("winding", [True, False])
def test_a_slow_pull_and_release_is_the_loop_computed_by_hand(coefficient: float, behind: float, winding: bool) -> None:
    run = loop(coefficient)
    branch = slice(0, STEPS) if winding else slice(2 * STEPS - 1, STEPS - 1, -1)
    end, before = by_hand(behind, coefficient, winding=winding)
    assert np.interp(end, run.end[branch], run.behind[branch]) == pytest.approx(behind, rel=6e-3)
    assert np.interp(end, run.end[branch], run.before[branch]) == pytest.approx(before, rel=6e-3)


@pytest.mark.parametrize("coefficient", [0.1, 0.2])
def test_at_a_reversal_the_servo_moves_by_the_capstans_part_before_the_rod_does(coefficient: float) -> None:
    run, top = loop(coefficient), 0.95 * FARTHEST
    behind = float(np.interp(top, run.end[:STEPS], run.behind[:STEPS]))
    bend = behind * ARM * ROD.length / ROD.bending_stiffness
    lost = behind * math.sinh(0.5 * coefficient * bend) / STIFFNESS
    assert run.lost == pytest.approx(lost, rel=0.05)
    assert lost > 2e-4


def test_without_friction_the_path_is_the_same_in_both_directions() -> None:
    run = loop(0.0)
    assert abs(run.lost) < 2e-5
    np.testing.assert_array_equal(run.before, run.behind)


def test_a_tendon_sticks_between_and_slides_beyond_and_a_slack_one_pulls_nothing() -> None:
    ratio = grip(0.2, -2.0)
    assert ratio == pytest.approx(math.exp(0.2))
    before = np.array([10.0, 10.0, 10.0])
    held = between(np.array([9.0, 5.0, 20.0]), before, ratio)
    assert held == pytest.approx([9.0, 10.0 / ratio, 10.0 * ratio])
    ends, shortening = np.array([0.0, -0.01, 0.01]), np.array([0.0, 0.0, 0.002])
    middles = TendonMiddles(STIFFNESS, np.zeros(3), np.zeros(3))
    middles.slide(ends, shortening, ratio)
    before, behind = middles.tension(ends), STIFFNESS * (middles.given(ends, shortening, ratio) - shortening)
    assert before[:2] == pytest.approx([0.0, 0.0])
    assert max(behind[:2]) <= 0.0
    assert before[2] == pytest.approx(ratio * behind[2])


@pytest.mark.parametrize("law", ["backstepping", "sliding_mode"])
def test_the_laws_track_through_friction_that_the_controller_knows_nothing_of(law: str) -> None:
    row = run_rig(law, COEFFICIENTS[-1])
    assert row.fault == ""
    assert row.settled is not None
    assert row.settled < row.arrival
    assert row.error_mm < 0.5


def test_the_table_in_the_docs_is_what_friction_does() -> None:
    """Renew it with `tendond bench friction`."""
    text = DOCS.read_text(encoding="utf-8")
    assert HEADING in text
    for coefficient in COEFFICIENTS[1:]:
        line = next(one for one in text.splitlines() if one.startswith(f"| {coefficient:g} | backstepping |"))
        servo, rod, lost = (float(number) for number in re.findall(r"\d+\.\d+", line.split("|", 3)[3])[:3])
        run = loop(coefficient)
        assert servo == pytest.approx(run.before[STEPS - 1], abs=0.1)
        assert rod == pytest.approx(run.behind[STEPS - 1], abs=0.1)
        assert lost == pytest.approx(1e3 * run.lost, abs=0.01)
