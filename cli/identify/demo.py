"""`tendond identify demo`: the proof on simulated rigs whose parameters are known."""

import json
import os
import time
from collections.abc import Sequence
from contextlib import closing
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from tendond.cli.common import say
from tendond.cli.identify.fit import write_results
from tendond.daemon.errors import DaemonError
from tendond.model.numerics.announce import announce_compilation
from tendond.model.warm import warm_up
from tendond.offline.identification.identify import SOURCES, Identification
from tendond.offline.identification.proof import (
    FACTORS,
    GOALS,
    USED,
    Outcome,
    Task,
    coverage,
    met,
    prove,
    record,
    redraw,
    truth,
    unknowns,
)
from tendond.offline.robustness.executors import spread
from tendond.offline.robustness.identified import MEASURES, matches, means, play, table
from tendond.offline.robustness.run import write_whole
from tendond.offline.source_hash import source_hash

SEEDS_FILE = "seeds.jsonl"
SUMMARY = "summary.json"
STUDIED = "tool"
"""The plant that other noise is put on."""


def run_identify_demo(out: Path, seeds: int, jobs: int | None) -> None:
    """Identify both rigs, compare the controllers, count over seeds; the results are in `out`.

    Raises:
        TendondError: no result, a goal missed, a folder that cannot be written.
    """
    announce_compilation(say)
    warm_up()
    console = Console()
    workers = jobs or len(os.sched_getaffinity(0))
    started = time.monotonic()
    try:
        out.mkdir(parents=True, exist_ok=True)
        columns = (TextColumn("{task.description:<28}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
        with Progress(*columns, console=console, disable=not console.is_terminal) as progress:
            tasks = [Task(plant, 1, str(out / plant)) for plant in FACTORS]
            proved = dict(_each(prove, tasks, workers, progress, "rigs identified"))
            values = {task.plant: outcome.values for task, (outcome, _) in proved.items()}
            played = _each(play, matches(values), workers, progress, "controllers compared")
            seconds = time.monotonic() - started
            outcomes = _study(out, seeds, workers, progress) if seeds else _known(out)
        summary = _summary(proved, table(played), outcomes, seconds)
        write_whole(out / SUMMARY, json.dumps(summary, indent=2) + "\n")
        for task in tasks:
            result = proved[task][1]
            for old in (out / task.plant).glob("identified-*.toml"):
                old.unlink()
            console.print(
                f"\nrig '{task.plant}', whose Young's modulus is {truth(task.plant)['E']:.4g} Pa", highlight=False
            )
            write_results(result, out / task.plant, datetime.now(UTC), console)
        _say(summary, console, out)
    except OSError as error:
        raise DaemonError(f"{error.filename or out}: {error.strerror}; choose another folder with --out") from error
    missed = [
        f"{plant}: {name}"
        for plant, rig in summary["rigs"].items()
        for name, good in rig["goals_met"].items()
        if not good
    ]
    if missed:
        raise DaemonError(f"goals missed: {', '.join(missed)}; see {out / SUMMARY}")


def _each(work: Any, tasks: Sequence[Any], workers: int, progress: Progress, words: str) -> list[tuple[Any, Any]]:
    """What `work` makes of each task, beside it, in the order of the tasks."""
    bar = progress.add_task(words, total=len(tasks))
    found: dict[int, Any] = {}
    with closing(spread(_Numbered(work), list(enumerate(tasks)), workers)) as results:
        for index, result in results:
            found[index] = result
            progress.advance(bar)
    return [(task, found[index]) for index, task in enumerate(tasks)]


class _Numbered:
    """A function of a task that keeps its number: results come in any order, and travel between processes."""

    def __init__(self, work: Any) -> None:
        self._work = work

    def __call__(self, numbered: tuple[int, Any]) -> tuple[int, Any]:
        return numbered[0], self._work(numbered[1])


def _study(out: Path, seeds: int, workers: int, progress: Progress) -> list[Outcome]:
    """Fits to other noise; those of this version that the folder has are not run again."""
    known = {outcome.task.seed: outcome for outcome in _known(out)}
    wanted = range(100, 100 + seeds)
    folder = out / "without-noise"
    tasks = [Task(STUDIED, seed, str(folder)) for seed in wanted if seed not in known]
    if tasks and not all((folder / f"{name}.mcap").exists() for name in USED):
        record(Task(STUDIED, 1, str(folder), noise=0.0))
    bar = progress.add_task("seeds", total=seeds, completed=seeds - len(tasks))
    version = source_hash(SOURCES)
    with (out / SEEDS_FILE).open("a", encoding="utf-8") as stream, closing(spread(redraw, tasks, workers)) as results:
        for outcome in results:
            known[outcome.task.seed] = outcome
            stream.write(json.dumps({"source": version, **asdict(outcome)}) + "\n")
            stream.flush()
            progress.advance(bar)
    return [known[seed] for seed in wanted]


def _known(out: Path) -> list[Outcome]:
    """Outcomes of seeds that the folder has of this version."""
    try:
        lines = (out / SEEDS_FILE).read_text(encoding="utf-8").splitlines()
    except FileNotFoundError:
        return []
    found = []
    for line in lines:
        try:
            values = json.loads(line)
            if values.pop("source") != source_hash(SOURCES):
                continue
            task = Task(**values.pop("task"))
            found.append(Outcome(task=task, **{**values, "missing": tuple(values["missing"])}))
        except (ValueError, KeyError, TypeError):  # cut off in the middle of a line
            continue
    return found


def _summary(
    proved: dict[Task, tuple[Outcome, Identification]],
    rows: list[dict[str, Any]],
    outcomes: list[Outcome],
    seconds: float,
) -> dict[str, Any]:
    """Everything as JSON has it."""
    rigs = {}
    for task, (outcome, result) in proved.items():
        true = truth(task.plant)
        assert outcome.held_out is not None
        rigs[task.plant] = {
            "seconds_of_logs": outcome.seconds,
            "goals_met": met(outcome),
            "parameters": {
                name: {
                    "truth": true[name],
                    "configuration": next(f.nominal for f in result.parameters if f.parameter.name == name),
                    "value": value,
                    "standard_error": outcome.errors[name],
                    "off_percent": 100.0 * (value / true[name] - 1.0) if true[name] else None,
                    "off_in_standard_errors": (value - true[name]) / outcome.errors[name],
                }
                for name, value in outcome.values.items()
            },
            "not_found": list(outcome.missing),
            "held_out_rms_mm": {
                "configuration": outcome.held_out[0] * 1e3,
                "identified": outcome.held_out[1] * 1e3,
            },
        }
    return {
        "goals": GOALS,
        "rigs": rigs,
        "control": {
            "means": {words: means([row for row in rows if row["rig"] in plants]) for words, plants in unknowns()},
            "points": rows,
        },
        "coverage": coverage(outcomes) if outcomes else None,
        "seconds": round(seconds, 1),
        "cores": len(os.sched_getaffinity(0)),
    }


def _say(summary: dict[str, Any], console: Console, out: Path) -> None:
    """Tables for the eye."""
    table = Table(
        box=None, padding=(0, 2, 0, 0), pad_edge=False, title="truth and what was found", title_justify="left"
    )
    for name in ("rig", "parameter", "truth", "found", "off", "in errors"):
        table.add_column(name, justify="left" if name in ("rig", "parameter") else "right")
    for plant, one in summary["rigs"].items():
        for name, row in one["parameters"].items():
            off = "-" if row["off_percent"] is None else f"{row['off_percent']:.3f} %"
            scaled = f"{row['off_in_standard_errors']:.2f}"
            table.add_row(plant, name, f"{row['truth']:.5g}", f"{row['value']:.5g}", off, scaled)
    console.print(table)
    for words, feedbacks in summary["control"]["means"].items():
        control = Table(
            box=None, padding=(0, 2, 0, 0), pad_edge=False, title=f"control, {words}", title_justify="left"
        )  # fmt: skip
        for name in ("feedback", "model", "points", "meet", *MEASURES):
            control.add_column(name, justify="left" if name in ("feedback", "model") else "right")
        for feedback, models in feedbacks.items():
            for model, row in models.items():
                numbers = (f"{row[name]:.3f}" if name in row else "-" for name in MEASURES)
                control.add_row(feedback, model, str(row["points"]), str(row["meet"]), *numbers)
        console.print(control)
    if summary["coverage"]:
        for name, row in summary["coverage"].items():
            within = f"truth within two errors {row['within_two']:.0%}, spread {row['spread']:.2f}"
            line = f"{name:<18}{row['fits']:4.0f} fits, {within}, bias {row['bias']:+.2f}"
            console.print(line, highlight=False)
    console.print(f"{summary['seconds']:.0f} s on {summary['cores']} cores\nsummary  {out / SUMMARY}", highlight=False)
