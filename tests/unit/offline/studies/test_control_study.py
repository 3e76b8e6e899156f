"""The comparison of laws: cases that go together, rows, goals that are missed."""

import dataclasses

import pytest

from tendond.offline.control.cases import PLANTS, ROBOTS, TASKS, UNIFORM, Case
from tendond.offline.control.report import HEADING, misses, row
from tendond.offline.control.run import Outcome, run

GOOD = Outcome(0.1, 0.2, 0.1, None, None, 0.01, 0, 2.0, 3.0, 60.0, "")


@pytest.mark.parametrize("task", UNIFORM)
def test_every_case_is_a_configuration(task: str) -> None:
    for plant in PLANTS:
        config = Case("mpc", task, plant).config()
        assert config.control.law == "mpc"
        assert (config.observer.delay > 0.0) == (plant in ("unlike", "wired"))
        assert (config.servo is not None) == (plant == "wired")


def test_robots_of_one_two_and_three_sections_have_tasks_of_their_own() -> None:
    for robot, sections in zip(ROBOTS, (1, 2, 3), strict=True):
        possible = [Case("mpc", task, "unlike", robot=robot) for task in TASKS]
        possible = [one for one in possible if one.possible]
        assert possible
        assert len(possible[0].config().rod.section or (None,)) == sections


def test_a_law_of_the_plane_is_left_out_in_space() -> None:
    assert not Case("backstepping", "helix", "matched").possible
    assert Case("backstepping", "paper's task", "matched").possible
    assert not Case("mpc", "helix", "matched", robot="rao-2021").possible
    assert not Case("mpc", "path with directions", "wired", robot="rao-2021").possible


def test_a_row_has_all_columns() -> None:
    assert row(Case("mpc", "helix", "matched"), GOOD).count("|") == HEADING.splitlines()[0].count("|")


def test_goals_are_of_the_best_law_and_of_the_cost() -> None:
    bad = dataclasses.replace(GOOD, rms_mm=5.0)
    slow = dataclasses.replace(GOOD, slow_ms=9.0)
    assert misses([(Case("mpc", "helix", "matched"), GOOD), (Case("sensitivity", "helix", "matched"), bad)]) == []
    assert len(misses([(Case("mpc", "helix", "matched"), slow)])) == 1
    assert len(misses([(Case("mpc", "helix", "matched"), bad)])) == 1
    assert len(misses([(Case("mpc", "helix", "matched"), dataclasses.replace(GOOD, fault="swing"))])) == 1


def test_goals_of_robots_of_sections_have_an_angle() -> None:
    case = Case("mpc", "path with directions", "matched", robot="rao-2021")
    turned = dataclasses.replace(GOOD, rms_mm=2.9, rms_degrees=1.9)
    assert misses([(case, turned)]) == []
    assert "degrees" in misses([(case, dataclasses.replace(turned, rms_degrees=2.1))])[0]
    assert "3 mm" in misses([(case, dataclasses.replace(turned, rms_mm=3.1))])[0]
    assert misses([(dataclasses.replace(case, plant="unlike"), dataclasses.replace(turned, rms_mm=9.0))]) == []


def test_a_path_of_a_robot_of_sections_is_measured_in_degrees_too() -> None:
    found = run(Case("sensitivity", "path with directions", "matched", robot="rao-2021"), 3.0)
    assert found.fault == ""
    assert found.rms_degrees is not None
    assert 0.0 < found.rms_degrees < 2.0


def test_a_short_run_has_its_numbers() -> None:
    found = run(Case("mpc", "circle 100 mm", "matched"), 0.5)
    assert found.fault == ""
    assert found.worst_mm < 1.0
    assert 0.0 < found.cycle_ms <= found.slow_ms
