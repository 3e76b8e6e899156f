"""The outcome of a trial, from a log of controller and simulated plant in lockstep."""

import numpy as np
import pytest

from tendond.offline.trying.outcome import TrialOutcome, outcome_of
from tests.golden.scripts import FOLDER


def test_a_tip_at_its_target_has_arrived_and_one_beside_it_or_in_motion_has_not() -> None:
    at = TrialOutcome((0.07, -1e-7, 0.18), (0.07, 0.0, 0.18), 1e-5, 1e-5, 0.2)
    assert at.arrived
    assert at.in_words() == "the tip rests at x 70.0, y 0.0, z 180.0 mm, 0.01 mm from its target"
    beside = TrialOutcome(at.tip, at.target, 5e-3, 1e-5, 0.2)
    assert not beside.arrived
    assert "rests at" in beside.in_words()
    moving = TrialOutcome(at.tip, at.target, 1e-5, 2e-3, 0.2)
    assert not moving.arrived
    assert "still moves by 2 mm" in moving.in_words()


def test_the_outcome_of_a_log_is_the_true_tip_beside_the_reference_at_the_end_of_tracking() -> None:
    outcome = outcome_of(FOLDER / "normal.mcap")
    apart = np.linalg.norm(np.subtract(outcome.tip, outcome.target))
    assert outcome.error == pytest.approx(apart)
    assert outcome.target[0] == pytest.approx(0.34, abs=1e-3)
    assert outcome.length == 0.5
