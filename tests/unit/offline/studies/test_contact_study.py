"""The study of contacts: what a run reports, and which rows meet the targets."""

import math
from pathlib import Path

import pytest

from tendond.offline.contact.cases import Case, contact_cases, free_cases
from tendond.offline.contact.report import contact_rows, free_rows, markdown, meets, write
from tendond.offline.contact.run import LATER, Outcome, Sample, Setting
from tendond.offline.contact.study import jobs

TOUCHED = Case("paper", False, 0.5)


def outcome(place: float, error: float, found: float = 0.04, alarms: int = 0, case: Case = TOUCHED) -> Outcome:
    sample = Sample(error, 0.1, 0.05, True, 0.2)
    return Outcome(case, 0, place, found, (sample,) * len(LATER), 0.03, alarms, 3.0, 1e-4)


def test_a_seeded_run_finds_its_contact_and_is_the_same_again() -> None:
    setting = Setting(TOUCHED)
    one, other = setting.run(1), setting.run(1)
    assert one == other
    assert 0.3 <= one.place <= 1.0
    assert 0.0 < one.found < 0.1
    assert one.samples[-1] is not None
    assert abs(one.samples[-1].place) < 0.15
    assert one.alarms == 0


def test_a_free_run_has_neither_contact_nor_alarm() -> None:
    free = Setting(Case("paper", False, 0.0)).run(1, 200)
    assert math.isnan(free.place)
    assert math.isnan(free.found)
    assert free.alarms == 0
    assert free.free == pytest.approx(2.0)


def test_a_row_meets_the_targets_by_medians_and_shares() -> None:
    good = [outcome(0.8, 0.01), outcome(0.9, 0.02), outcome(0.95, 0.3)]
    (row,) = contact_rows(good)
    assert row.meets
    assert row.place == 0.02
    late = [*good, outcome(0.8, 0.01, found=0.2)]
    assert not contact_rows(late)[0].meets
    assert not contact_rows([outcome(0.8, 0.3)])[0].meets


def test_more_than_one_alarm_an_hour_misses_the_target() -> None:
    once, twice = free_rows([outcome(0.8, 0.0, alarms=1)]), free_rows([outcome(0.8, 0.0, alarms=2)])
    assert meets([], once)
    assert not meets([], twice)


def test_parts_that_the_targets_are_not_for_do_not_miss_them() -> None:
    rows = contact_rows([outcome(0.35, 0.3), outcome(0.8, 0.01)])
    assert [row.goal for row in rows] == [False, True]
    assert meets(rows, [])
    assert "0.3 to 0.5 L" in markdown(rows, [])


def test_the_files_have_a_line_a_run(tmp_path: Path) -> None:
    some = [outcome(0.8, 0.01), outcome(0.4, 0.02)]
    write(some, contact_rows(some), free_rows(some), tmp_path)
    assert len((tmp_path / "results.csv").read_text().splitlines()) == 3
    assert (tmp_path / "report.md").read_text().count("| paper, resting, 0.5 N |") == 2


def test_each_case_has_so_many_runs() -> None:
    assert len(jobs(3, 2, 0)) == 3 * len(contact_cases()) + 2 * len(free_cases())
