"""The campaign of the safety filter: cases by seed, the measure of the truth, and the file it goes on from."""

from pathlib import Path

import numpy as np
import pytest

from tendond import TendondError
from tendond.offline.safety.campaign import FILE, meets, read, summary
from tendond.offline.safety.cases import drawn
from tendond.offline.safety.run import Outcome, _strain, clearance_of, run

GOOD = Outcome(0, "paper", "sensitivity", "sphere", 0.02, 0.02, -0.1, 100, 0, "")
BAD = Outcome(1, "nitinol", "backstepping", "strain", -0.01, -0.02, None, 50, 3, "limits: x")


def test_a_seed_is_a_case_and_the_plant_differs_from_the_model() -> None:
    one, again, other = drawn(5), drawn(5), drawn(6)
    assert one == again
    assert one.config != other.config
    assert one.config.safety is not None
    assert one.config.simulator.rod != one.config.rod


def test_the_truth_is_held_against_the_constraint_itself() -> None:
    case = next(one for one in map(drawn, range(40)) if one.kind == "tip_region")
    assert case.config.safety is not None
    region = case.config.safety.tip_region
    assert region is not None
    assert region.point is not None
    assert region.normal is not None
    inside = np.linspace(np.zeros(3), np.array(region.point) + 0.01 * np.array(region.normal), 11)
    assert clearance_of(case, inside) == pytest.approx(0.01 / case.config.rod.backbone_length)


def test_the_strain_of_an_arc_is_radius_over_radius() -> None:
    angle = np.linspace(0.0, 1.0, 41)
    arc = 0.5 * np.stack((1.0 - np.cos(angle), np.zeros(41), np.sin(angle)), axis=1)
    assert _strain(arc, 1e-3) == pytest.approx(2e-3, rel=1e-3)


def test_one_violation_fails_the_study_and_none_without_the_filter_too() -> None:
    assert meets(summary([GOOD], 150))
    assert not meets(summary([GOOD, BAD], 150))
    easy = Outcome(0, "paper", "sensitivity", "sphere", 0.02, 0.02, 0.01, 0, 0, "")
    assert not meets(summary([easy], 150))
    whole = summary([GOOD, BAD], 150)[0]
    assert (whole.violations, whole.released, whole.without, whole.compared, whole.faults) == (1, 1, 1, 1, 1)
    assert whole.clearance == -0.01


def test_a_file_of_something_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / FILE).write_text("a,b\n1,2\n")
    with pytest.raises(TendondError, match="choose another --out"):
        read(tmp_path)
    assert read(tmp_path / "none") == []


def test_a_run_judges_the_true_plant() -> None:
    outcome = run(2, compare=False, cycles=40)
    assert outcome.clearance > 0.0
    assert outcome.released <= outcome.clearance
    assert outcome.without is None
    assert outcome.altered > 0
