"""The comparison of laws: cases that go together, rows, goals that are missed."""

import dataclasses

import pytest

from tendond.offline.control.cases import PLANTS, TASKS, Case
from tendond.offline.control.report import HEADING, misses, row
from tendond.offline.control.run import Outcome, run

GOOD = Outcome(0.1, 0.2, 0.1, None, 0.01, 0, 2.0, 3.0, 60.0, "")


@pytest.mark.parametrize("task", TASKS)
def test_every_case_is_a_configuration(task: str) -> None:
    for plant in PLANTS:
        config = Case("mpc", task, plant).config()
        assert config.control.law == "mpc"
        assert (config.observer.delay > 0.0) == (plant == "unlike")


def test_a_law_of_the_plane_is_left_out_in_space() -> None:
    assert not Case("backstepping", "helix", "matched").possible
    assert Case("backstepping", "paper's task", "matched").possible


def test_a_row_has_all_columns() -> None:
    assert row(Case("mpc", "helix", "matched"), GOOD).count("|") == HEADING.splitlines()[0].count("|")


def test_goals_are_of_the_best_law_and_of_the_cost() -> None:
    bad = dataclasses.replace(GOOD, rms_mm=5.0)
    slow = dataclasses.replace(GOOD, slow_ms=9.0)
    assert misses([(Case("mpc", "helix", "matched"), GOOD), (Case("sensitivity", "helix", "matched"), bad)]) == []
    assert len(misses([(Case("mpc", "helix", "matched"), slow)])) == 1
    assert len(misses([(Case("mpc", "helix", "matched"), bad)])) == 1
    assert len(misses([(Case("mpc", "helix", "matched"), dataclasses.replace(GOOD, fault="swing"))])) == 1


def test_a_short_run_has_its_numbers() -> None:
    found = run(Case("mpc", "circle 100 mm", "matched"), 0.5)
    assert found.fault == ""
    assert found.worst_mm < 1.0
    assert 0.0 < found.cycle_ms <= found.slow_ms
