"""The paper reproduced: how close the runs are, and what tables, figures and page make of them."""

import csv
import json
import re
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tendond.cli.study.paper import run_paper
from tendond.daemon.control.laws import LAWS as REGISTERED
from tendond.daemon.errors import DaemonError
from tendond.offline.paper.draw import figures
from tendond.offline.paper.edge import EDGE_NEIGHBOURS
from tendond.offline.paper.lyapunov import CAUSES, along_share, find_rises, measured_rate, rate_of
from tendond.offline.paper.page import page
from tendond.offline.paper.published import EXPERIMENT, LAWS, SIMULATION
from tendond.offline.paper.run import PaperRun, Runs, process_pool, run_all, run_scenario
from tendond.offline.paper.scenarios import (
    DISTURBANCE,
    DISTURBED_AT,
    IMPACT_PLACE,
    IMPACT_SIZE,
    IMPACTS,
    SEED,
    STRING,
    paper_scenarios,
    random_impacts,
)
from tendond.offline.paper.tables import bounds, comparison, results, write_tables
from tendond.offline.plots.appearance import Appearance, appearing

SCENARIOS = {(one.name, one.law): one for one in paper_scenarios()}

PRINTED_KEYS = {
    "source",
    "table_simulation_normal",
    "table_experiment_normal",
    "final_tendon_displacement_mm",
    "final_tip_x_mm",
    "initial_tip_z_mm",
}
ROW_KEYS = {
    "tpl_mm",
    "settling_iterations_5pct",
    "overshoot_pct",
    "rise_iterations_0_90",
    "steady_state_error_mm",
}


RUN = (
    "normal",
    "normal_edge",
    "normal_edge_exchanged",
    *(f"edge_near {name}" for name in list(EDGE_NEIGHBOURS)[:2]),
    "disturbance",
    "weight_50g",
    "rig_normal",
    "rig_normal_direct",
    "rig_weight_50g",
    "rig_impacts",
    "weight_20g_found",
    "weight_50g_found",
)
"""The scenarios that the tests run; `make paper` runs them all."""


@pytest.fixture(scope="module")
def runs() -> Runs:
    with ThreadPoolExecutor(1) as pool:
        return run_all([one for one in SCENARIOS.values() if one.name in RUN], pool, lambda name: None)


def both(runs: Runs, scenario: str) -> tuple[PaperRun, PaperRun]:
    return runs[scenario, "backstepping"], runs[scenario, "sliding_mode"]


def test_backstepping_is_as_close_to_the_papers_row_as_it_must_be(runs: Runs) -> None:
    """TPL within 10 %, settling and rise within 2 iterations, overshoot within 2 points, no steady error."""
    found, paper = runs["normal", "backstepping"].metrics, SIMULATION["backstepping"]
    assert found.tpl_mm == pytest.approx(paper.tpl_mm, rel=0.1)
    assert found.settling_iterations == pytest.approx(paper.settling_iterations, abs=2)
    assert found.rise_iterations == pytest.approx(paper.rise_iterations, abs=2)
    assert found.overshoot_percent == pytest.approx(paper.overshoot_percent, abs=2.0)
    assert found.steady_state_error_mm < 0.05
    assert found.final_displacement_m * 1e3 == pytest.approx(58.0, abs=1.0)
    assert all(bound.met(runs) for bound in bounds())


def test_with_the_same_information_both_laws_are_equally_smooth(runs: Runs) -> None:
    first, second = both(runs, "normal")
    assert second.metrics.tpl_mm == pytest.approx(first.metrics.tpl_mm, rel=0.02)


def test_at_the_edge_the_papers_contrast_appears_and_goes_with_the_gains(runs: Runs) -> None:
    first, second = both(runs, "normal_edge")
    exchanged = both(runs, "normal_edge_exchanged")
    assert second.metrics.tpl_mm > 1000.0
    assert second.metrics.tpl_mm > 2.0 * first.metrics.tpl_mm
    assert exchanged[0].metrics.tpl_mm == pytest.approx(second.metrics.tpl_mm, rel=0.05)
    assert exchanged[1].metrics.tpl_mm == pytest.approx(first.metrics.tpl_mm, rel=0.05)


def test_both_laws_run_under_the_same_condition() -> None:
    for (name, law), scenario in SCENARIOS.items():
        other = SCENARIOS[name, LAWS[1 - LAWS.index(law)]].config
        control = other.control.model_copy(update={"law": law})
        assert scenario.config == other.model_copy(update={"control": control})
    assert set(LAWS) <= set(REGISTERED)


def test_a_pool_of_processes_gives_the_same_runs(runs: Runs) -> None:
    names = ("rig_normal",)
    done: list[str] = []
    with process_pool(2) as pool:
        found = run_all([one for key, one in SCENARIOS.items() if key[0] in names], pool, done.append)
    assert list(found) == [key for key in SCENARIOS if key[0] in names]
    assert len(done) == len(found)
    for key, run in found.items():
        assert np.array_equal(run.tip, runs[key].tip)
        assert run.metrics == runs[key].metrics


def test_the_disturbance_acts_in_the_step_after_iteration_50_and_in_no_other(runs: Runs) -> None:
    force = runs["disturbance", "backstepping"].tip_force
    assert np.flatnonzero(np.any(force != 0.0, axis=1)).tolist() == [DISTURBED_AT + 1]
    assert force[DISTURBED_AT + 1].tolist() == list(DISTURBANCE)


def test_a_weight_pulls_along_gravity_and_a_hanging_one_in_changing_directions(runs: Runs) -> None:
    still, hanging = (runs[name, "backstepping"].tip_force for name in ("weight_50g", "rig_weight_50g"))
    assert np.allclose(still, (-0.05 * 9.81, 0.0, 0.0))
    assert SCENARIOS["rig_weight_50g", "backstepping"].config.simulator.weight.string == STRING
    angles = np.arctan2(hanging[:, 2], -hanging[:, 0])
    assert np.ptp(angles) > 0.5


def test_random_impacts_are_the_same_for_a_seed_and_within_their_ranges() -> None:
    pushes = random_impacts(SEED)
    assert pushes == random_impacts(SEED)
    assert pushes != random_impacts(SEED + 1)
    assert len(pushes) == IMPACTS
    for _, _, force, place in pushes:
        assert IMPACT_SIZE[0] <= np.linalg.norm(force) <= IMPACT_SIZE[1]
        assert IMPACT_PLACE[0] <= place <= IMPACT_PLACE[1]
    assert len({push[0] for push in pushes}) == len({push[3] for push in pushes}) == IMPACTS


def test_a_scenario_whose_tracking_starts_at_another_tick_is_refused() -> None:
    scenario = SCENARIOS["normal", "backstepping"]
    pretension = scenario.config.pretension.model_copy(update={"duration": 0.004})
    late = replace(scenario, config=scenario.config.model_copy(update={"pretension": pretension}), iterations=5)
    with pytest.raises(DaemonError, match="scenario normal: tracks from tick"):
        run_scenario(late)


def test_the_lyapunov_functions_fall_as_theory_says_but_for_the_first_cycle(runs: Runs) -> None:
    for run in both(runs, "normal"):
        found = find_rises(run)
        assert found.limit.tolist() == [0]
        assert not found.rank.size
        assert not found.sampled.size
        assert measured_rate(run) == pytest.approx(2.0 * rate_of(run), rel=0.15)
        assert along_share(run) > 0.99


def test_every_rise_of_v_has_one_cause(runs: Runs) -> None:
    for name in ("normal", "normal_edge", "disturbance"):
        for run in both(runs, name):
            found = find_rises(run)
            named = np.concatenate([found.of(cause) for cause in CAUSES])
            assert sorted(named.tolist()) == np.flatnonzero(np.diff(run.lyapunov) > 0.0).tolist()
            assert len(named) + found.falls == len(run.lyapunov) - 1


def test_v_is_half_the_squares_of_the_errors_that_it_is_split_by(runs: Runs) -> None:
    for run in both(runs, "normal_edge"):
        assert run.lyapunov == pytest.approx(0.5 * (run.errors**2).sum(axis=(1, 2)), rel=1e-9)


def test_results_have_the_form_of_the_papers(runs: Runs, tmp_path: Path) -> None:
    write_tables(runs, tmp_path, "normal", "normal_edge", "rig_normal")
    written = json.loads((tmp_path / "results.json").read_text())
    assert written == results(runs, "normal", "rig_normal")
    assert set(written) == PRINTED_KEYS
    for table in ("table_simulation_normal", "table_experiment_normal"):
        assert set(written[table]) == set(LAWS)
        assert all(set(row) == ROW_KEYS for row in written[table].values())
    assert written["table_simulation_normal"]["backstepping"]["tpl_mm"] == runs["normal", "backstepping"].metrics.tpl_mm
    assert written["final_tip_x_mm"] == pytest.approx(340.0, abs=0.1)
    assert written["initial_tip_z_mm"] == pytest.approx(500.0, abs=1.0)


def test_the_tables_show_the_papers_number_ours_and_the_difference(runs: Runs, tmp_path: Path) -> None:
    write_tables(runs, tmp_path, "normal", "normal_edge", "rig_normal")
    for name, paper in (("simulation", SIMULATION), ("experiment", EXPERIMENT)):
        rows = list(csv.DictReader((tmp_path / f"{name}.csv").read_text().splitlines()))
        assert len(rows) == 2 * len(LAWS) * len(ROW_KEYS)
        for row in rows:
            assert float(row["paper"]) == getattr(paper[row["law"]], row["criterion"])
            if row["ours"]:
                assert float(row["difference"]) == pytest.approx(float(row["ours"]) - float(row["paper"]))
    first = comparison(SIMULATION, {law: runs["normal", law] for law in LAWS})[0]
    ours = runs["normal", "backstepping"].metrics.tpl_mm
    assert first[1:3] == ["407.8", f"{ours:.1f}"]
    assert first[3].startswith(f"{ours - 407.79:+.1f} (")


def test_the_page_shows_every_figure_and_its_tables_are_whole(runs: Runs) -> None:
    stand_ins = {key: replace(runs["normal", key[1]], scenario=one) for key, one in SCENARIOS.items()}
    text = page({**stand_ins, **runs})
    assert set(re.findall(r"\]\((\w+)\.png\)", text)) == set(figures())
    assert "nan" not in text
    for table in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE):
        assert len({line.count("|") for line in table.splitlines()}) == 1, table


def test_the_page_shows_figures_of_the_format_that_was_drawn(runs: Runs) -> None:
    stand_ins = {key: replace(runs["normal", key[1]], scenario=one) for key, one in SCENARIOS.items()}
    text = page({**stand_ins, **runs}, "svg")
    assert "(normal.svg)" in text
    assert ".png)" not in text


@pytest.mark.parametrize(("iterations", "label"), [(False, "time [s]"), (True, "iteration")])
def test_figures_have_the_axis_and_formats_that_are_asked_for(
    runs: Runs, tmp_path: Path, iterations: bool, label: str
) -> None:
    draw, scenarios = figures()["normal_edge"]
    with appearing(Appearance("ieee", ("svg", "pdf"), iterations=iterations)):
        draw({key: run for key, run in runs.items() if key[0] in scenarios}, tmp_path / "normal.png")
    svg = (tmp_path / "normal.svg").read_text()
    assert f">{label}</text>" in svg
    assert ">(a)</text>" in svg
    assert (tmp_path / "normal.pdf").stat().st_size > 5000


def test_figures_are_drawn(runs: Runs, tmp_path: Path) -> None:
    drawn = ("normal_edge", "configurations", "disturbance_sliding_mode", "experiment_impacts", "lyapunov")
    chosen = {name: figure for name, figure in figures().items() if name in drawn}
    for name, (draw, scenarios) in chosen.items():
        needed = {key: run for key, run in runs.items() if key[0] in scenarios}
        path = draw(needed, tmp_path / f"{name}.png")
        assert path.read_bytes().startswith(b"\x89PNG")
        assert path.stat().st_size > 20_000


def test_a_folder_that_cannot_be_made_is_one_line(tmp_path: Path) -> None:
    taken = tmp_path / "file"
    taken.write_text("")
    with pytest.raises(DaemonError, match=r"file: File exists; choose another folder with --out"):
        run_paper(taken)
