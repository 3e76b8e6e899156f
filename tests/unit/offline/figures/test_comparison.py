"""`log compare`: units, formats of the table, repeats with their confidence, names that tell runs apart."""

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest

from tendond.offline.comparison.repeats import as_groups, mean_of
from tendond.offline.comparison.runs import compared, metric, names, notes
from tendond.offline.comparison.table import as_csv, as_latex, as_markdown, table_of
from tendond.offline.logs.log import load
from tendond.offline.logs.summary import LABELS
from tendond.offline.plots.compare import overlay
from tendond.schemas.config.rig import RigConfig
from tests.golden.scripts import FOLDER
from tests.unit.logs.commands import run_command
from tests.unit.offline.figures.logs import approach, idle, write_simulated

NORMAL, FAULTS = FOLDER / "normal.mcap", FOLDER / "faults.mcap"


def seeded(folder: Path, seed: int, target: float, law: str = "backstepping") -> Path:
    """A run that goes to `target` instead of where it should, with a seed."""
    config = RigConfig.model_validate({"simulator": {"seed": seed}, "control": {"law": law}})
    return write_simulated(folder / f"{law}-{seed}.mcap", approach(0, 60, target), None, config)


def test_a_mean_has_the_interval_of_students_t() -> None:
    found = mean_of([1.0, 2.0, 3.0])
    assert found is not None
    assert (found.value, found.count, found.runs) == (2.0, 3, 3)
    assert found.half_width == pytest.approx(4.302653 / 3**0.5, rel=1e-6)  # t of 2 degrees at 97.5 %, s = 1
    alone = mean_of([4.0, None])
    assert alone is not None
    assert (alone.value, alone.half_width, alone.count, alone.runs) == (4.0, None, 1, 2)
    assert mean_of([None, None]) is None


def test_runs_that_differ_only_in_their_seeds_are_repeats(tmp_path: Path) -> None:
    logs = [load(seeded(tmp_path, seed, 0.33 + 0.01 * seed)) for seed in range(3)]
    logs.append(load(seeded(tmp_path, 7, 0.34, "sliding_mode")))
    groups = as_groups(compared(logs))
    assert [len(one.members) for one in groups] == [3, 1]
    mean = groups[0].metrics["final_tip_x_m"]
    assert mean.value == pytest.approx(0.34, abs=1e-6)
    assert mean.half_width == pytest.approx(4.302653 * 0.01 / 3**0.5, rel=1e-3)
    text = as_markdown(table_of(groups), [])
    assert "(n = 3)" in text
    assert "0.340 ± 0.025" in text
    assert "95 % confidence interval (Student's t)" in text


def test_a_metric_that_some_repeats_lack_says_how_many_have_it(tmp_path: Path) -> None:
    logs = [load(seeded(tmp_path, seed, target)) for seed, target in ((0, 0.34), (1, 0.34), (2, 0.2))]
    text = as_markdown(table_of(as_groups(compared(logs))), [])
    assert "± 0 (2 of 3)" in text


def test_logs_of_the_same_name_are_told_apart_by_the_folders_that_differ() -> None:
    assert names([Path("/a/x/run.mcap"), Path("/b/x/run.mcap")]) == ["a/x/run", "b/x/run"]
    assert names([Path("/a/one.mcap"), Path("/a/two.mcap")]) == ["one", "two"]
    assert names([Path("/a/run.mcap"), Path("/a/run.mcap")]) == ["run", "run (2)"]


def test_every_run_of_a_log_is_compared(tmp_path: Path) -> None:
    path = write_simulated(tmp_path / "two.mcap", approach(0, 40) + idle(40, 10) + approach(50, 40))
    assert [one.name for one in compared([load(path)])] == ["two run 1", "two run 2"]


def test_every_metric_has_a_name_and_a_unit(tmp_path: Path) -> None:
    path = write_simulated(tmp_path / "a.mcap", approach(0, 60), {30: "impact"})
    (one,) = compared([load(path)])
    assert metric("recovery_1_s") == ("recovery_1_s", "recovery 1", "s")
    assert metric("recovery_1_deviation_mm")[2] == "mm"
    assert "recovery_1_s" in one.metrics
    for key in one.metrics:
        _, name, unit = metric(key)
        assert name
        assert unit, key
    assert metric("tpl_mm")[1:] == LABELS["tpl_mm"]


def test_a_table_is_written_as_csv_with_units() -> None:
    table = table_of(compared([load(NORMAL), load(FAULTS)]))
    rows = list(csv.reader(io.StringIO(as_csv(table, []))))
    assert rows[0][:3] == ["metric", "unit", "normal"]
    assert all(len(row) == len(rows[0]) for row in rows)
    found = {row[0]: row for row in rows}
    assert found["peak_tension_n"][1] == "N"
    assert float(found["tpl_mm"][2]) > 300.0


def test_a_table_of_latex_has_the_rules_of_booktabs_and_no_bare_special_sign() -> None:
    text = as_latex(table_of(compared([load(NORMAL)])), ["a_note"])
    for rule in ("\\toprule", "\\midrule", "\\bottomrule", "\\usepackage{booktabs}"):
        assert rule in text
    body = [line for line in text.splitlines() if line.endswith("\\\\")]
    assert len(body) > 10
    assert all(line.count("&") == 2 for line in body)
    assert all("%" not in line.replace("\\%", "") and "_" not in line.replace("\\_", "") for line in body)


@pytest.mark.parametrize(("form", "ending", "mark"), [("csv", "csv", "metric,unit,"), ("markdown", "md", "| --- |"),
                                                      ("latex", "tex", "\\toprule")])  # fmt: skip
def test_the_command_prints_and_writes_the_table_in_the_format_that_is_asked_for(
    tmp_path: Path, form: str, ending: str, mark: str
) -> None:
    result = run_command("log", "compare", str(NORMAL), "--table", form, "--format", "svg", "--out", str(tmp_path))
    assert result.returncode == 0, result.stderr
    assert result.stdout == (tmp_path / f"metrics.{ending}").read_text()
    assert mark in result.stdout
    assert "compare.svg" in result.stderr
    again = run_command("log", "compare", str(NORMAL), "--table", form, "--format", "svg", "--out", str(tmp_path))
    assert again.returncode == 1
    assert again.stdout == result.stdout
    assert "exists already" in again.stderr


def test_the_tip_of_a_replay_on_the_same_inputs_is_said_to_be_the_recordings(tmp_path: Path) -> None:
    other = tmp_path / "other.mcap"
    run_command("log", "what-if", str(NORMAL), "--law", "sliding_mode", "--out", str(other))
    found = compared([load(NORMAL), load(other)])
    assert [one.recording for one in found] == ["", "normal.mcap"]
    (line,) = notes(found)
    assert line.startswith("other: computed from the inputs of normal.mcap: the metrics of its tip are those of")
    result = run_command("log", "compare", str(NORMAL), str(other), "--out", str(tmp_path / "out"))
    assert line in result.stdout
    as_json = run_command("log", "compare", str(other), "--out", str(tmp_path / "json"), "--json")
    assert json.loads(as_json.stdout)["other"]["tip_metrics_of"] == "normal.mcap"


def test_comparisons_without_a_folder_have_one_each(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for _ in range(3):
        assert run_command("log", "compare", str(NORMAL)).returncode == 0
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["compare", "compare-2", "compare-3"]


def test_the_curves_mark_what_was_injected_in_their_runs(tmp_path: Path) -> None:
    impact = dict.fromkeys(range(20, 25), "impact")
    pushed = load(write_simulated(tmp_path / "pushed.mcap", approach(0, 60), impact))
    figure = overlay(compared([load(write_simulated(tmp_path / "calm.mcap", approach(0, 60))), pushed]))
    for axes in figure.axes:
        (mark,) = [line for line in axes.lines if line.get_label() == "injected, pushed"]
        assert np.asarray(mark.get_xdata(), dtype=float)[0] == pytest.approx(0.2)
