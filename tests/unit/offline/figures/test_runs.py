"""`log plot`: all runs of a log, no file replaced, gaps left open, and what it could read of a cut log."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from tendond.offline.logs.log import load
from tendond.offline.logs.metrics import runs
from tendond.offline.logs.paths import TipPath
from tendond.offline.plots.figures import NAMES, PANELS, shapes_figure
from tendond.offline.plots.panels import Panels
from tendond.offline.plots.report import page
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleRecord
from tests.golden.scripts import FOLDER
from tests.unit.logs.commands import run_command
from tests.unit.offline.figures.logs import approach, idle, write_simulated
from tests.unit.offline.records import cycle_record, write_log

NORMAL = FOLDER / "normal.mcap"


def two_runs(folder: Path) -> Path:
    """A log with two runs, the second to another place."""
    records = idle(0, 10) + approach(10, 40) + idle(50, 10) + approach(60, 30)
    return write_log(folder / "two.mcap", records)


def test_each_run_of_a_log_has_its_figures(tmp_path: Path) -> None:
    result = run_command("plot", str(two_runs(tmp_path)))
    assert result.returncode == 0, result.stderr
    found = {path.name for path in (tmp_path / "two-plots").iterdir()}
    for number in (1, 2):
        assert {f"two-run{number}-{name}.png" for name in NAMES} <= found
    assert {"two-timeline.png", "two-timing.png", "two-run2-space.png"} <= found


def test_a_plot_replaces_no_other_unless_asked_to(tmp_path: Path) -> None:
    one = two_runs(tmp_path)
    out = tmp_path / "figures"
    assert run_command("plot", str(one), "--out", str(out)).returncode == 0
    before = {path.name: path.stat().st_mtime_ns for path in out.iterdir()}
    again = run_command("plot", str(one), "--out", str(out))
    assert again.returncode == 1
    assert "exists already; --force replaces it, --out takes another place" in again.stderr
    assert {path.name: path.stat().st_mtime_ns for path in out.iterdir()} == before
    assert run_command("plot", str(one), "--out", str(out), "--force").returncode == 0
    assert run_command("plot", str(NORMAL), "--out", str(out)).returncode == 0  # another name


def test_a_gap_in_the_log_is_a_gap_in_the_curve(tmp_path: Path) -> None:
    records = approach(0, 60)
    log = load(write_simulated(tmp_path / "a.mcap", records[:30] + records[40:]))
    axes = Figure().subplots()
    Panels(log, runs(log)[0]).error(axes)
    values = np.asarray(axes.lines[0].get_ydata())
    assert np.isnan(values).sum() == 1
    assert np.isnan(values[30])


def test_the_path_of_the_tip_is_not_joined_from_run_to_run(tmp_path: Path) -> None:
    log = load(two_runs(tmp_path))
    whole = TipPath.of(log)
    assert np.isnan(whole.tip[45:48]).all()
    assert np.isfinite(whole.tip[:40]).all()
    second = runs(log)[1]
    path = TipPath.of(log, (int(second.ticks[0]), int(second.ticks[-1])))
    assert len(path.time) == len(second.ticks)


def test_the_probe_is_no_part_of_the_path_of_a_run(tmp_path: Path) -> None:
    probe = [cycle_record(i, (0.01 * (-1) ** i, 0.0, 0.5), Mode.PROBE) for i in range(10)]
    log = load(write_log(tmp_path / "a.mcap", probe + approach(10, 30)))
    assert len(TipPath.of(log, (10, 39)).time) == 30


def test_shapes_do_not_pile_up(tmp_path: Path) -> None:
    back_and_forth = [
        cycle_record(i, (0.34 * abs(np.sin(0.1 * i)), 0.0, 0.5 - 0.3 * abs(np.sin(0.1 * i)))) for i in range(400)
    ]
    log = load(write_log(tmp_path / "a.mcap", back_and_forth))
    axes = shapes_figure(log).axes[0]
    rods = [line for line in axes.lines if len(np.asarray(line.get_xdata())) == 50]
    tips = np.array([[np.asarray(line.get_xdata())[-1], np.asarray(line.get_ydata())[-1]] for line in rods])
    apart = np.linalg.norm(tips[:, None] - tips[None], axis=2)[np.triu_indices(len(tips), 1)]
    assert len(log.shapes) == 80
    assert 4 <= len(rods) <= 25
    assert apart.min() >= 24.9  # 5 % of 500 mm


def test_what_could_be_read_of_a_cut_log_is_said(tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(NORMAL.read_bytes()[:-5000])
    for command in (("plot", str(cut)), ("log", "compare", str(cut), "--out", str(tmp_path / "compared"))):
        result = run_command(*command)
        assert result.returncode == 0
        assert "cut.mcap: its end is missing" in result.stderr
        assert "cycles, up to" in result.stderr
    whole = run_command("plot", str(NORMAL), "--out", str(tmp_path / "whole"))
    assert "missing" not in whole.stderr


@pytest.mark.parametrize("size", [9, 300, 2000])
def test_a_log_that_was_cut_before_its_first_record_is_called_cut(tmp_path: Path, size: int) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(NORMAL.read_bytes()[:size])
    result = run_command("plot", str(cut))
    assert result.returncode == 2
    assert f"was cut off after {size} bytes, before its first record" in result.stderr


def test_a_report_shows_tables_of_the_configuration_whole(tmp_path: Path) -> None:
    impacts = [{"time": 0.5 + i, "force": (1.0, 0.0, 0.0)} for i in range(6)]
    config = RigConfig.model_validate({"simulator": {"impacts": impacts}})
    log = load(write_log(tmp_path / "a.mcap", approach(0, 40), config))
    facts = {"started": "", "duration_s": 0.4, "cycles": 40, "rejected": {}, "faults": [], "complete": True}
    text = page(log, {**facts, "damage": [], "missing_ticks": 0, "missed_deadlines": 0})
    assert "simulator.impacts[5].time</td><td>5.5" in text
    assert "{&#x27;time&#x27;" not in text


def test_each_panel_is_a_figure_of_its_own_where_it_is_asked_for(tmp_path: Path) -> None:
    log = write_log(tmp_path / "a.mcap", approach(0, 40))
    run_command("plot", str(log))
    assert not any((tmp_path / "a-plots" / f"a-{name}.png").exists() for name in PANELS)
    run_command("plot", str(log), "--panels", "--out", str(tmp_path / "each"))
    found = {path.name for path in (tmp_path / "each").iterdir()}
    assert {f"a-{name}.png" for name in (*PANELS, *NAMES)} <= found
    assert tuple(Panels(load(log), runs(load(log))[0]).all) == PANELS


def test_an_injection_is_marked_in_every_panel(tmp_path: Path) -> None:
    log = load(write_simulated(tmp_path / "a.mcap", approach(0, 60), {30: "impact", 31: "impact"}))
    panels = Panels(log, runs(log)[0])
    assert panels.shown == 60  # nothing is left out behind it
    for draw in panels.all.values():
        axes = Figure().subplots()
        draw(axes)
        legend = axes.get_legend()
        assert legend is not None
        assert "injected: impact" in [text.get_text() for text in legend.get_texts()]


def test_a_target_at_zero_is_plotted_without_metrics(tmp_path: Path) -> None:
    records = [replace_target(record) for record in approach(0, 30)]
    path = write_log(tmp_path / "a.mcap", records)
    result = run_command("plot", str(path))
    assert result.returncode == 0, result.stderr
    assert (tmp_path / "a-plots" / "a-overview.png").exists()


def replace_target(record: CycleRecord) -> CycleRecord:
    """The same record with a target on the axis of the rod."""
    point = record.reference.model_copy(update={"target": (0.0, 0.0, 0.4)})
    return record.model_copy(update={"reference": point})
