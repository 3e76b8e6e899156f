"""Weights of which the controller knows nothing, on the plant by others."""

import json

import pytest

from tests.plants.weight_run import Case, run
from tests.plants.weights import main

CASES = [
    Case(mass=50.0, stiffness=0.85, unknown_delay=1),
    Case(mass=35.0, law="sensitivity", rate=250, stiffness=1.15, known_delay=3),
]


@pytest.mark.parametrize("case", CASES, ids=["50 g", "35 g in space"])
def test_the_tip_settles_under_a_weight_on_a_plant_by_others(case: Case) -> None:
    outcome = run(case)
    assert outcome.passed, outcome


def test_a_run_that_swings_falls_short(capsys: pytest.CaptureFixture[str]) -> None:
    """Poses 150 ms older than configured."""
    status = main(["--json", "--jobs", "1", "--tracking", "4", "--law", "backstepping", "--rate", "100",
                   "--mass", "0", "--stiffness", "1", "--known-delay", "0", "--unknown-delay", "15"])  # fmt: skip
    (row,) = map(json.loads, capsys.readouterr().out.splitlines())
    assert status == 1
    assert not row["passed"]
