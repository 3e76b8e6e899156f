"""Runs of real points: measures, resuming an interrupted run, and reports."""

import json
import sys
from collections.abc import Generator, Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from tendond.cli.app import app
from tendond.daemon.errors import UsageError
from tendond.drivers.simulator.rods import PlantRod, plant_rod
from tendond.offline.robustness import executors
from tendond.offline.robustness.evaluate import PointResult, evaluate
from tendond.offline.robustness.executors import Chunk, Done, ExecutorError, on_cluster, run_chunk
from tendond.offline.robustness.figure import draw
from tendond.offline.robustness.points import Point
from tendond.offline.robustness.report import report
from tendond.offline.robustness.results import NAME
from tendond.offline.robustness.run import Rows, csv_text, run
from tendond.offline.robustness.settings import Settings
from tendond.offline.robustness.summary import counts, misses, summary, worst
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.simulator import SimulatorSection

BASE = RigConfig()
NOMINAL = Point("axes", "backstepping", "force")
SETTINGS = Settings("sample", 3, 1, ("backstepping",), None, BASE)


def shooting_plant(section: SimulatorSection, time_step: float) -> PlantRod:
    """The plant by the shooting rod, which has no solution for a rope; by default it would be the general one."""
    return plant_rod(section.model_copy(update={"solver": "shooting"}), time_step)


def no_progress(done: int, total: int, missed: int) -> None:
    pass


def here(chunks: Sequence[Chunk]) -> Generator[Done, None, None]:
    """Run chunks in this process, one after the other."""
    yield from map(run_chunk, chunks)


def test_the_nominal_plant_meets_the_goal_and_direct_feedback_with_a_cycle_of_delay_does_not() -> None:
    good = evaluate(BASE, NOMINAL, 0)
    assert good.meets
    assert good.settling_iterations is not None
    assert good.settling_iterations <= 45
    bad = evaluate(BASE, replace(NOMINAL, feedback="direct", delay_cycles=1), 0)
    assert (bad.meets, bad.settles, bad.smooth) == (False, False, False)
    assert bad.ripple_mm is not None
    assert bad.ripple_mm > 5.0


def test_ripple_and_settling_are_of_the_tip_and_not_of_its_noisy_pose() -> None:
    result = evaluate(BASE, replace(NOMINAL, noise_mm=0.3), 0)
    assert result.ripple_mm is not None
    assert result.ripple_mm < 0.15
    assert result.settling_iterations is not None


def test_a_weight_is_found_as_a_force() -> None:
    result = evaluate(BASE, replace(NOMINAL, load_g=20.0), 0)
    assert result.force_error_n is not None
    assert result.force_error_n < 0.1 * 0.02 * 9.81
    assert evaluate(BASE, replace(NOMINAL, feedback="offset", load_g=20.0), 0).force_error_n is None


def test_an_impact_is_seen_after_the_tip_had_settled() -> None:
    calm, hit = evaluate(BASE, NOMINAL, 0), evaluate(BASE, replace(NOMINAL, impact_n=10.0, impact_ms=50.0), 0)
    assert (calm.settling_iterations, calm.ripple_mm) == (hit.settling_iterations, hit.ripple_mm)
    assert calm.impact_settling_iterations is None
    assert hit.impact_settling_iterations is None or hit.impact_settling_iterations > 0


def test_the_rate_limits_cost_is_counted_and_bounded_by_the_tendons_travel() -> None:
    result = evaluate(BASE, replace(NOMINAL, drive="displacement"), 0)
    assert 20 < result.rate_cost_iterations < 0.08 / 0.085 / 0.01


def test_a_fault_misses_the_goal_and_says_why() -> None:
    strict = BASE.model_copy(update={"limits": BASE.limits.model_copy(update={"limit_time": 0.05})})
    result = evaluate(strict, replace(NOMINAL, drive="displacement"), 0)
    assert (result.meets, result.mode, result.settling_iterations) == (False, "fault", None)
    assert "limits" in result.reason
    assert misses(result) == ("fault",)


def test_a_plant_that_has_no_solution_is_a_result_and_not_the_end_of_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tendond.drivers.simulator.lockstep.plant_rod", shooting_plant)
    result = evaluate(BASE, replace(NOMINAL, youngs_factor=1e-4), 0)
    assert (result.meets, result.mode) == (False, "fault")
    assert "the plant has no solution" in result.reason


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Rows, bytes]:
    """Rows and CSV of a run that nothing interrupted."""
    folder = tmp_path_factory.mktemp("whole")
    return run(SETTINGS, folder, here, no_progress), (folder / "results.csv").read_bytes()


def test_an_interrupted_run_goes_on_with_what_is_left(tmp_path: Path, whole: tuple[Rows, bytes]) -> None:
    def broken_off(chunks: Sequence[Chunk]) -> Generator[Done, None, None]:
        yield run_chunk(chunks[0])
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(SETTINGS, tmp_path, broken_off, no_progress)
    assert not (tmp_path / "results.csv").exists()
    with (tmp_path / NAME).open("ab") as results:
        results.write(b'{"point": "backstepping/for')  # killed while it wrote
    ran: list[int] = []

    def counted(chunks: Sequence[Chunk]) -> Generator[Done, None, None]:
        ran.extend(index for chunk in chunks for index, _ in chunk.points)
        yield from here(chunks)

    run(SETTINGS, tmp_path, counted, no_progress)
    assert ran == [2]
    assert (tmp_path / "results.csv").read_bytes() == whole[1]
    assert all(json.loads(line) for line in (tmp_path / NAME).read_text().splitlines())


def test_results_that_come_in_another_order_are_the_same_file(tmp_path: Path, whole: tuple[Rows, bytes]) -> None:
    run(SETTINGS, tmp_path, lambda chunks: here(chunks[::-1]), no_progress)
    assert (tmp_path / "results.csv").read_bytes() == whole[1]


def test_a_folder_with_results_of_other_settings_is_refused_without_fresh(tmp_path: Path) -> None:
    none = replace(SETTINGS, count=1)
    run(none, tmp_path, here, no_progress)
    other = replace(none, seed=2)
    with pytest.raises(UsageError, match=r"other settings \(seed: 1, now 2\); choose another folder"):
        run(other, tmp_path, here, no_progress)
    gained = BASE.model_copy(update={"observer": BASE.observer.model_copy(update={"integral": 7.0})})
    with pytest.raises(UsageError, match=r"config\.observer\.integral: 5\.0, now 7\.0"):
        run(replace(none, config=gained), tmp_path, here, no_progress)
    assert len(run(other, tmp_path, here, no_progress, fresh=True)) == 1


def test_a_folder_that_another_run_writes_to_is_refused(tmp_path: Path) -> None:
    def second(chunks: Sequence[Chunk]) -> Generator[Done, None, None]:
        with pytest.raises(UsageError, match="another run writes its results there"):
            run(one, tmp_path, here, no_progress)
        yield from here(chunks)

    one = replace(SETTINGS, count=1)
    assert len(run(one, tmp_path, second, no_progress)) == 1


def test_a_foreign_results_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / NAME).write_text("not json\n")
    with pytest.raises(UsageError, match="is not a results file of this program; start again with --fresh"):
        run(SETTINGS, tmp_path, here, no_progress)


def test_never_settling_is_worse_than_any_number_and_is_named(whole: tuple[Rows, bytes]) -> None:
    rows = [
        (NOMINAL, PointResult(settling_iterations=20, ripple_mm=0.3, mode="tracking", settles=True)),
        (replace(NOMINAL, lag_factor=0.5), PointResult(ripple_mm=0.1, mode="tracking")),
    ]
    slow, rough = worst(rows, "settling_iterations"), worst(rows, "ripple_mm")
    assert slow is not None
    assert rough is not None
    assert (slow[0].lag_factor, rough[0].lag_factor) == (0.5, 0.0)
    assert counts(rows)["misses_settles"] == 1
    page = summary(rows, {})["known"][0]
    assert page["worst"]["settling_iterations"] == {"value": None, "at": "lag 0.5", "part": "axes"}
    assert "impact_settling_iterations" not in page["worst"]


def test_the_csv_has_a_line_a_point_with_units_in_its_heading(whole: tuple[Rows, bytes]) -> None:
    head, *lines = csv_text(whole[0]).splitlines()
    assert len(lines) == len(whole[0]) == SETTINGS.count
    assert {"delay_cycles", "noise_mm", "ripple_mm", "peak_tension_n", "meets"} <= set(head.split(","))


def test_report_and_figure_show_every_feedback_beside_the_default(tmp_path: Path) -> None:
    rows = [
        (point, evaluate(BASE, point, 0))
        for point in (NOMINAL, replace(NOMINAL, feedback="offset"), replace(NOMINAL, feedback="direct", delay_cycles=1))
    ]
    page = report(rows, SETTINGS.as_json())
    assert "| plant | force | offset | direct |" in page
    assert "| delay 1 |  |  | **" in page
    assert draw(rows, tmp_path / "heatmap.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        (("--points", "all"), "'all': choose one of default, axes, corners, grid, sample"),
        (("--feedback", "none"), "'none': choose one of force, offset, direct"),
        (("--points", "axes", "--count", "3"), "the set 'axes' has no random points"),
    ],
)
def test_options_that_cannot_be_are_refused(arguments: tuple[str, ...], match: str) -> None:
    result = CliRunner().invoke(app, ["study", "robustness", *arguments])
    assert result.exit_code == 2
    assert match in result.output


def test_a_cluster_without_dask_names_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ExecutorError, match=r"--cluster needs Dask, .* pip install 'tendond\[cluster\]'"):
        list(on_cluster([], "tcp://127.0.0.1:1"))


def test_a_cluster_that_does_not_respond_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(executors, "CONNECT_SECONDS", 0.5)
    with pytest.raises(ExecutorError, match=r"^--cluster tcp://127\.0\.0\.1:1: no Dask scheduler responds there .*$"):
        list(on_cluster([], "tcp://127.0.0.1:1"))
