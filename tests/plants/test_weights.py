"""Weights of which the controller knows nothing, on the plant by others."""

import json

import pytest

from tests.plants.weights import Case, main, run


@pytest.mark.parametrize("rate", [100, 250])
def test_the_tip_settles_on_a_plant_by_others(rate: int) -> None:
    outcome = run(Case(rate=rate, mass=0.0), tracking=4.0)
    assert outcome.passed, outcome


def test_what_swings_falls_short(capsys: pytest.CaptureFixture[str]) -> None:
    """Poses 150 ms older than the observer is told."""
    status = main(["--json", "--jobs", "1", "--tracking", "4", "--law", "backstepping", "--rate", "100",
                   "--mass", "0", "--stiffness", "1", "--told", "0", "--untold", "15"])  # fmt: skip
    (row,) = map(json.loads, capsys.readouterr().out.splitlines())
    assert status == 1
    assert not row["passed"]
