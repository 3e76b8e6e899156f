"""Plants under the commands of the nominal run: as one by one, in closed form, and in the study's files."""

import csv
import io
import itertools
import json
from collections.abc import Generator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from tendond.cli.study.robustness import _errors_table
from tendond.drivers.simulator.lockstep import open_loop
from tendond.offline.robustness.evaluate import PointResult, evaluate
from tendond.offline.robustness.executors import Chunk, Done
from tendond.offline.robustness.open_loop import by_general_rod, nominal_run, open_loop_tips, with_open_loop
from tendond.offline.robustness.plants import rig_of
from tendond.offline.robustness.points import Point
from tendond.offline.robustness.report import report
from tendond.offline.robustness.run import Rows, csv_text, run
from tendond.offline.robustness.settings import Settings
from tendond.offline.robustness.summary import removed, summary
from tendond.schemas.config.rig import RigConfig, check_config
from tests.unit.offline.test_robustness_run import here, no_progress

ARM = check_config(
    {
        "rod": {"preset": "rao-2021"},
        "control": {"law": "sensitivity"},
        "reference": {"across": 0.12},
        "limits": {"tension_max": 6.0},
        "pretension": {"tension_min": 0.1},
    },
    "arm",
)
NOMINAL = Point("axes", "sensitivity", "force")
WEIGHTLESS = check_config({"rod": {"gravity": [0.0, 0.0, 0.0]}}, "paper")


def with_friction(config: RigConfig, friction: float) -> RigConfig:
    """The same rig, whose plant's tendons rub on their guides."""
    servo = config.simulator.servo.model_copy(update={"friction": friction})
    return config.model_copy(update={"simulator": config.simulator.model_copy(update={"servo": servo})})


@pytest.mark.parametrize("drive", ["tension", "displacement"])
def test_all_plants_at_once_move_as_each_one_alone(drive: str) -> None:
    found = nominal_run(ARM, "sensitivity", drive)
    assert found is not None
    points = (
        replace(NOMINAL, drive=drive),
        replace(NOMINAL, drive=drive, youngs_factor=0.9, bending_damping_factor=2.0, lag_factor=0.5),
        replace(NOMINAL, drive=drive, load_g=1.0),
    )
    configs = [by_general_rod(rig_of(ARM, point, 0)) for point in points]
    configs.append(with_friction(configs[1], 0.2))
    tips = open_loop_tips(found, configs, threads=2)
    for lane, config in enumerate(configs):
        alone = np.array([truth.position for _, truth in open_loop(config, found.commands)])
        assert tips[1:, lane] == pytest.approx(alone[:-1], abs=1e-12)
    for one, other in itertools.combinations(range(len(configs)), 2):  # they are unlike, and so are their motions
        assert np.abs(tips[:, one] - tips[:, other]).max() > 1e-5


def test_a_softer_rod_without_weight_is_off_by_its_larger_curvature() -> None:
    """Tendons at r bend a rod to the curvature r T / EI, whose tip is at (1 - cos(k L)) / k."""
    found = nominal_run(WEIGHTLESS, "backstepping", "tension")
    assert found is not None
    tension = np.array(found.commands[-1].tension)
    rod = WEIGHTLESS.rod
    bending = rod.youngs_modulus * np.pi * rod.radius**4 / 4.0
    moment = np.hypot(*(np.array(rod.tendon_positions).T @ tension))

    def tip(factor: float) -> float:
        curvature = moment / (factor * bending)
        return float((1.0 - np.cos(curvature * rod.length)) / curvature)

    nominal = Point("axes", "backstepping", "force")
    points = [nominal, replace(nominal, noise_mm=0.3), replace(nominal, youngs_factor=0.85)]
    rows = with_open_loop(WEIGHTLESS, [(point, PointResult()) for point in points], threads=1)
    known, noisy, soft = (result.open_loop_error_mm for _, result in rows)
    assert known is not None
    assert soft is not None
    assert noisy == known
    assert known < 0.05
    assert soft == pytest.approx(1e3 * abs(tip(0.85) - tip(1.0)), abs=1e-3)
    assert soft > 10.0


@pytest.fixture(scope="module")
def rows() -> Rows:
    """The nominal point, a softer plant and one that is loaded, in closed loop."""
    points = (NOMINAL, replace(NOMINAL, youngs_factor=0.9), replace(NOMINAL, load_g=1.0))
    return [(point, evaluate(ARM, point, 0)) for point in points]


def test_the_nominal_plant_ends_where_it_does_in_closed_loop_and_others_do_not(rows: Rows) -> None:
    nominal, *others = (result for _, result in with_open_loop(ARM, rows))
    assert nominal.open_loop_error_mm == pytest.approx(nominal.steady_error_mm, abs=1e-9)
    for result in others:
        assert result.open_loop_error_mm is not None
        assert result.steady_error_mm is not None
        assert result.open_loop_error_mm > 10.0 * result.steady_error_mm


def test_the_open_loop_is_added_to_results_that_a_folder_has(tmp_path: Path, rows: Rows, monkeypatch: Any) -> None:
    points = [point for point, _ in rows]
    monkeypatch.setattr("tendond.offline.robustness.run.points_of", lambda *given, **more: points)
    settings = Settings("axes", 1, 0, ("sensitivity",), ("force",), ARM)

    def nothing_left(chunks: Sequence[Chunk]) -> Generator[Done, None, None]:
        raise AssertionError("points are run again")
        yield

    first = run(settings, tmp_path, here, no_progress)
    assert all(result.open_loop_error_mm is None for _, result in first)
    again = run(settings, tmp_path, nothing_left, no_progress, open_loop_threads=1)
    assert [result for _, result in again] == [result for _, result in with_open_loop(ARM, first)]
    cells = list(csv.DictReader(io.StringIO((tmp_path / "results.csv").read_text())))
    assert [float(row["open_loop_error_mm"]) > 1.0 for row in cells] == [False, True, True]


def test_reports_compare_both_errors_of_the_points_that_track_to_the_end() -> None:
    tracks = PointResult(mode="tracking", settles=True, smooth=True, bounded=True, recovers=True)
    rows = [
        (replace(NOMINAL, load_g=load), replace(tracks, steady_error_mm=closed, open_loop_error_mm=loop))
        for load, closed, loop in ((0.0, 0.01, 0.0), (1.0, 0.02, 30.0), (2.0, 0.5, 50.0))
    ]
    rows.append(
        (replace(NOMINAL, load_g=9.0), PointResult(mode="fault", steady_error_mm=90.0, open_loop_error_mm=99.0))
    )
    found = removed(rows)
    assert found is not None
    assert found["points"] == 3
    assert found["open_loop"] == {"median": 30.0, "p95": pytest.approx(48.0), "worst": 50.0, "at": "load 2 g"}
    assert found["closed_loop"]["median"] == 0.02
    assert json.loads(json.dumps(summary(rows, {})))["known"][0]["feedback_removes"] == found
    settings = Settings("axes", 1, 0, ("sensitivity",), ("force",), ARM).as_json()
    page = report(rows, settings)
    assert "| sensitivity | force | 3 | 30 | 48 | 50 | 0.02 | 0.452 | 0.5 | load 2 g |" in page
    console = Console(record=True, width=200)
    console.print(_errors_table(rows))
    assert "0.452" in console.export_text()
    bare = [(point, replace(result, open_loop_error_mm=None)) for point, result in rows]
    assert "What the feedback removes" not in report(bare, settings)
    assert ",open_loop_error_mm," in csv_text(bare).splitlines()[0]


def test_a_law_whose_nominal_run_does_not_track_has_no_error_in_open_loop() -> None:
    limits = WEIGHTLESS.limits.model_copy(update={"limit_time": 0.05})
    strict = WEIGHTLESS.model_copy(update={"limits": limits})
    assert nominal_run(strict, "backstepping", "displacement") is None  # the drive's rate limit is a fault by then
    point = Point("axes", "backstepping", "force", drive="displacement")
    ((_, result),) = with_open_loop(strict, [(point, PointResult())])
    assert result.open_loop_error_mm is None
