"""`tendond study robustness --points space`: courses in space, a figure each, and the law on the task in the plane."""

import csv
import functools
import json
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from tendond.cli.common import load_config, say
from tendond.daemon.errors import DaemonError
from tendond.model.numerics.announce import announce_compilation
from tendond.model.warm import warm_up
from tendond.offline.trials.measure import Outcome, planar_task, run_trial
from tendond.offline.trials.paths import MATCHED_RMS_MM, UNLIKE_RMS_MM, Trial, trials

PLANAR_LAWS = ("backstepping", "sliding_mode", "sensitivity")
COLUMNS = ("rms_mm", "worst_mm", "largest_change_n", "least_tension_n", "peak_tension_n", "limited", "mode", "reason")


def run_trials(
    config: Path | None, out: Path, seed: int, jobs: int | None, chosen: Callable[[Trial], bool] = lambda trial: True
) -> None:
    """Run the courses and leave table, summary, report and figures in `out`.

    Raises:
        TendondError: a configuration that cannot be used, or a folder that cannot be written.
    """
    base = load_config(config)
    announce_compilation(say)
    warm_up()
    some, console = [trial for trial in trials() if chosen(trial)], Console()
    try:
        out.mkdir(parents=True, exist_ok=True)
        with console.status("running the courses"), ProcessPoolExecutor(jobs) as pool:
            outcomes = list(pool.map(functools.partial(run_trial, base, seed=seed), some))
        planar = planar_task(base, PLANAR_LAWS)
        _write(some, outcomes, planar, out)
        with console.status("drawing"):
            from tendond.offline.trials.figure import draw

            for trial, outcome in zip(some, outcomes, strict=True):
                draw(trial, outcome, out / f"{trial.file}.png")
    except OSError as error:
        raise DaemonError(f"{error.filename or out}: {error.strerror}; choose another folder with --out") from error
    console.print(_table(some, outcomes))
    console.print(f"report   {out / 'report.md'}", soft_wrap=True, highlight=False)


def _write(some: list[Trial], outcomes: list[Outcome], planar: dict[str, Any], out: Path) -> None:
    with (out / "results.csv").open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(("course", "plant", *COLUMNS, "notes", "meets"))
        for trial, outcome in zip(some, outcomes, strict=True):
            cells = (getattr(outcome, name) for name in COLUMNS)
            writer.writerow((trial.name, trial.plant, *cells, "; ".join(outcome.notes), str(outcome.meets).lower()))
    courses = [
        {"course": trial.name, "plant": trial.plant, "goal_mm": trial.goal_mm, "meets": outcome.meets}
        | {name: getattr(outcome, name) for name in COLUMNS}
        for trial, outcome in zip(some, outcomes, strict=True)
    ]
    values = {"courses": courses, "planar": planar}
    (out / "summary.json").write_text(json.dumps(values, indent=2) + "\n", encoding="utf-8")
    (out / "report.md").write_text(_report(some, outcomes, planar), encoding="utf-8")


def _report(some: list[Trial], outcomes: list[Outcome], planar: dict[str, Any]) -> str:
    lines = [
        "# Courses in space, with the law 'sensitivity'",
        "",
        f"Goal: RMS of tip to reference below {MATCHED_RMS_MM:g} mm where the plant is the model, below "
        f"{UNLIKE_RMS_MM:g} mm where it is not. The tip is the simulated one, from the course's beginning on.",
        "",
        "| course | plant | RMS mm | worst mm | change of tension N/cycle | tensions N | meets |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    lines += [
        f"| [{trial.name}]({trial.file}.png) | {trial.plant} | {one.rms_mm:.2f} | {one.worst_mm:.2f} | "
        f"{one.largest_change_n:.2f} | {one.least_tension_n:.1f} to {one.peak_tension_n:.1f} | "
        f"{'yes' if one.meets else 'no: ' + (one.reason if one.mode != 'tracking' else 'RMS')} |"
        for trial, one in zip(some, outcomes, strict=True)
    ]
    lines += [
        "",
        "The paper's task in the plane, on the model itself:",
        "",
        "| law | settling | TPL mm | way of the tip mm | steady error mm | rate of the tensions N/s |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    lines += [
        f"| {law.replace('_', ' ')} | {values['settling_iterations']} | {values['tpl_mm']:.1f} | "
        f"{values['path_mm']:.1f} | {values['steady_error_mm']:.3f} | {values['tension_rate_n_s']:.0f} |"
        for law, values in planar.items()
    ]
    return "\n".join(lines) + "\n"


def _table(some: list[Trial], outcomes: list[Outcome]) -> Table:
    table = Table(box=None, padding=(0, 1, 0, 0), pad_edge=False)
    for name in ("course", "plant", "RMS mm", "worst mm", "N/cycle", "peak N", "meets"):
        table.add_column(name, justify="left" if name in ("course", "plant") else "right", no_wrap=True)
    for trial, one in zip(some, outcomes, strict=True):
        numbers = (one.rms_mm, one.worst_mm, one.largest_change_n, one.peak_tension_n)
        plant = "unlike" if trial.unlike else "model"
        table.add_row(trial.name, plant, *(f"{value:.2f}" for value in numbers), "yes" if one.meets else "no")
    return table
