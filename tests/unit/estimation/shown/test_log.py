"""The filter in tables, figures and the report of a log."""

import csv
from pathlib import Path

import numpy as np
import pytest

from tendond.offline.logs import load
from tendond.offline.logs.export import export
from tendond.offline.logs.log import load as load_log
from tendond.offline.plots import report
from tendond.offline.plots.filter import filter_figure, filter_figures, has_filter, tip_bound, tip_error
from tendond.offline.plots.report import write_report
from tests.golden.scripts import FOLDER
from tests.unit.cli.commands import tendond
from tests.unit.estimation.shown.conftest import CYCLES, PUSH, Filtered

NORMAL = FOLDER / "normal.mcap"


def test_the_fields_of_the_filter_are_arrays_with_units(filtered: Filtered) -> None:
    run = load(filtered.path)
    known = [record.observer.filter for record in filtered.records]
    covariances = [one.tip_covariance for one in known if one is not None]
    np.testing.assert_array_equal(run["observer.filter.tip_covariance"], covariances)
    start = "observer.filter."
    assert {name.removeprefix(start): unit for name, unit in run.units.items() if name.startswith(start)} == {
        "tip_covariance": "m^2",
        "force_covariance": "N^2",
        "tension_error": "N",
        "tension_deviation": "N",
        "bend_error": "N m",
        "stiffness": "",
        "stiffness_deviation": "",
        "consistency": "",
        "load_tick": "",
    }


def test_the_columns_of_a_table_name_axes_and_units(filtered: Filtered, tmp_path: Path) -> None:
    export(load(filtered.path), tmp_path / "run.csv")
    with (tmp_path / "run.csv").open() as stream:
        row = list(csv.DictReader(stream))[100]
    known = filtered.records[100].observer.filter
    assert known is not None
    assert float(row["observer_filter_tip_covariance_xy_m2"]) == known.tip_covariance[1]
    assert float(row["observer_filter_force_covariance_zz_N2"]) == known.force_covariance[5]
    assert float(row["observer_filter_tension_deviation_0_N"]) == known.tension_deviation[0]
    assert float(row["observer_filter_bend_error_1_N_m"]) == known.bend_error[1]
    assert float(row["observer_filter_stiffness"]) == known.stiffness


def test_the_figure_has_force_with_its_band_error_with_its_bound_and_consistency(filtered: Filtered) -> None:
    log, run = load_log(filtered.path), load(filtered.path)
    force, tip, consistency = filter_figure(log).axes
    curves = {str(line.get_label()): np.asarray(line.get_ydata()) for line in (*force.lines, *tip.lines)}
    np.testing.assert_array_equal(curves["y ± 2σ"], run["observer.force"][:, 1])
    assert curves["true y"][-1] == PUSH[1]
    assert len(force.collections) == 3
    band = force.collections[1].get_paths()[0].get_extents()
    deviation = np.sqrt(run["observer.filter.force_covariance"][:, 3])
    assert band.y1 == pytest.approx(np.max(run["observer.force"][:, 1] + 2.0 * deviation))
    np.testing.assert_array_equal(curves["95 % of the tip lie within"], 1e3 * tip_bound(run))
    np.testing.assert_array_equal(curves["error of the model's tip"], 1e3 * tip_error(run))
    np.testing.assert_array_equal(consistency.lines[0].get_ydata(), run["observer.filter.consistency"])


def test_the_error_is_to_the_truth_of_the_next_cycle_in_which_the_model_is(filtered: Filtered) -> None:
    """An arm that rises without loads is followed closely: a period earlier and later it is far from there."""
    run = load(filtered.path)
    error = tip_error(run)
    same = np.linalg.norm(run["model.position"] - run["truth.position"], axis=1)
    rises = slice(8, 22)
    later = np.linalg.norm(run["model.position"][:-2] - run["truth.position"][2:], axis=1)
    assert np.all(error[rises] < 0.3 * same[rises])
    assert np.all(error[rises] < 0.3 * later[rises])
    assert np.isnan(error[-1])
    assert np.isfinite(error[:-1]).sum() == CYCLES - 1


def test_plot_and_report_have_the_figure_only_where_there_is_a_filter(
    filtered: Filtered, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(report, "_image", lambda _, name: f'<img alt="{name}">')  # drawing takes seconds
    done = tendond(capsys, "plot", str(filtered.path), "--out", str(tmp_path))
    assert done.status == 0, done.said
    assert (tmp_path / f"{filtered.path.stem}-filter.png").stat().st_size > 20_000
    assert 'alt="Filter"' in write_report(filtered.path, tmp_path / "run.html").read_text(encoding="utf-8")
    normal = load_log(NORMAL)
    assert not has_filter(normal)
    assert filter_figures(normal) == []
    assert 'alt="Filter"' not in write_report(NORMAL, tmp_path / "normal.html").read_text(encoding="utf-8")
