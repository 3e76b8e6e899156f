"""`tendond bench rod --references`: textbooks that need no files, and what the command says and returns."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from tendond.offline.bench.general_rod import references, textbooks
from tendond.offline.bench.general_rod.references import ReferenceRow
from tendond.offline.bench.general_rod.timing import MORE, WITH_FRICTION, bench_general
from tests.unit.cli.commands import tendond


@pytest.mark.parametrize(
    "figure", [textbooks.elastica, textbooks.helix, textbooks.curved_cantilever, textbooks.follower]
)
def test_the_general_rod_keeps_to_textbooks_by_a_ten_thousandth_of_its_length(figure: Callable[[], float]) -> None:
    assert figure() < 1e-4


def test_an_upright_rod_buckles_under_its_weight_when_the_book_says() -> None:
    assert textbooks.heavy_column() < 1e-3


def test_without_data_the_command_says_where_to_get_them(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv("TENDOND_REFERENCE_DATA", raising=False)
    for given, said in (("", "set TENDOND_REFERENCE_DATA"), (str(tmp_path), f"{tmp_path}: holds no reference data")):
        ended = tendond(capsys, "bench", "rod", "--references", given)
        assert ended.status != 0
        assert said in ended.said
        assert "github.com/ContinuumRoboticsLab/opencr-mujoco" in ended.said


@pytest.mark.parametrize(("found", "status", "word"), [(2e-4, 1, "NO"), (5e-5, 0, "yes"), (None, 0, "-")])
def test_the_exit_status_is_one_where_a_target_is_missed(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    found: float | None,
    status: int,
    word: str,
) -> None:
    (tmp_path / "opencr-mujoco").mkdir()
    row = ReferenceRow("a book", "a tip", found, 1e-4, "L", "" if found else "the file is not there")
    monkeypatch.setattr("tendond.cli.bench.references.compare", lambda folder, progress: [row])
    ended = tendond(capsys, "bench", "rod", "--references", str(tmp_path))
    assert ended.status == status
    assert f"| {word} |" in ended.out
    ended = tendond(capsys, "bench", "rod", "--json", "--references", str(tmp_path))
    assert ended.status == status
    assert json.loads(ended.out)[0]["passed"] == row.passed


def test_files_that_are_not_there_are_named_and_miss_no_target(tmp_path: Path) -> None:
    rows = [
        row
        for part in (references._statics, references._releases, references._two_tendons)
        for row in part(tmp_path, lambda name: None)
    ]
    assert len(rows) == 5
    assert all(row.passed is None and "not there" in row.note for row in rows)


def test_the_general_rod_is_timed_beside_the_shooting_rod_in_one_run() -> None:
    rows = {row.name: row for row in bench_general(steps=3, batch=3)}
    assert rows["shooting rod, 10 ms"].to_shooting == 1.0
    assert sum(MORE in name for name in rows) == 4
    assert rows[WITH_FRICTION].to_step * rows["one section, 4 tendons: 10 ms"].median_us == pytest.approx(
        rows[WITH_FRICTION].median_us
    )
    for row in rows.values():
        assert row.to_shooting * rows["shooting rod, 10 ms"].median_us == pytest.approx(row.median_us)
