"""Identification validated on simulated rigs: values, errors over seeds, and controllers with and without it."""

import json
import os
import time
from collections.abc import Sequence
from contextlib import closing
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.progress import Progress

from tendond.offline.files import write_whole
from tendond.offline.identification.identify import SOURCES
from tendond.offline.identification.proof.prove import GOALS, ProofOutcome, coverage, met, prove, redraw
from tendond.offline.identification.proof.rigs import FACTORS, USED, ProofTask, record, truth, unknowns
from tendond.offline.identification.results.result import Identification
from tendond.offline.robustness.executors import spread
from tendond.offline.robustness.identified import matches, means, play, table
from tendond.offline.source_hash import source_hash

SEEDS_FILE = "seeds.jsonl"
SUMMARY = "summary.json"
STUDIED = "tool"
"""The plant that other noise is put on."""

Proved = dict[ProofTask, tuple[ProofOutcome, Identification]]


def validate(out: Path, seeds: int, workers: int, progress: Progress) -> tuple[Proved, dict[str, Any]]:
    """Identify each simulated rig, compare the controllers, repeat with other noise, and write the summary.

    Args:
        out: folder of logs and summary.
        seeds: repetitions with other noise; 0: those that the folder has.
        workers: processes.
        progress: shows what has been done.

    Raises:
        OSError: the folder cannot be written.
    """
    started = time.monotonic()
    tasks = [ProofTask(plant, 1, str(out / plant)) for plant in FACTORS]
    proved: Proved = dict(_each(prove, tasks, workers, progress, "rigs identified"))
    values = {task.plant: outcome.values for task, (outcome, _) in proved.items()}
    played = _each(play, matches(values), workers, progress, "controllers compared")
    seconds = time.monotonic() - started
    outcomes = _study(out, seeds, workers, progress) if seeds else _known(out)
    summary = _summary(proved, table(played), outcomes, seconds)
    write_whole(out / SUMMARY, json.dumps(summary, indent=2) + "\n")
    return proved, summary


def _each(work: Any, tasks: Sequence[Any], workers: int, progress: Progress, words: str) -> list[tuple[Any, Any]]:
    """Run `work` on each task in processes; pairs of task and result, in the order of the tasks."""
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


def _study(out: Path, seeds: int, workers: int, progress: Progress) -> list[ProofOutcome]:
    """Fits to other noise; those of this version that the folder has are not run again."""
    known = {outcome.task.seed: outcome for outcome in _known(out)}
    wanted = range(100, 100 + seeds)
    folder = out / "without-noise"
    tasks = [ProofTask(STUDIED, seed, str(folder)) for seed in wanted if seed not in known]
    if tasks and not all((folder / f"{name}.mcap").exists() for name in USED):
        record(ProofTask(STUDIED, 1, str(folder), noise=0.0))
    bar = progress.add_task("seeds", total=seeds, completed=seeds - len(tasks))
    version = source_hash(SOURCES)
    with (out / SEEDS_FILE).open("a", encoding="utf-8") as stream, closing(spread(redraw, tasks, workers)) as results:
        for outcome in results:
            known[outcome.task.seed] = outcome
            stream.write(json.dumps({"source": version, **asdict(outcome)}) + "\n")
            stream.flush()
            progress.advance(bar)
    return [known[seed] for seed in wanted]


def _known(out: Path) -> list[ProofOutcome]:
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
            task = ProofTask(**values.pop("task"))
            found.append(ProofOutcome(task=task, **{**values, "missing": tuple(values["missing"])}))
        except (ValueError, KeyError, TypeError):  # cut off in the middle of a line
            continue
    return found


def _summary(
    proved: dict[ProofTask, tuple[ProofOutcome, Identification]],
    rows: list[dict[str, Any]],
    outcomes: list[ProofOutcome],
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
