"""`tendond identify demo`: validation on simulated rigs whose parameters are known."""

import os
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from tendond.cli.common import say
from tendond.cli.extras import need
from tendond.cli.identify.fit import print_results
from tendond.daemon.errors import DaemonError
from tendond.model.numerics.announce import announce_compilation
from tendond.model.warm import warm_up, warm_up_trajectories
from tendond.offline.demo.identification import SUMMARY, validate
from tendond.offline.identification.proof.rigs import truth
from tendond.offline.identification.results.report import write_results
from tendond.offline.progress import bars
from tendond.offline.robustness.identified import MEASURES


def run_identify_demo(out: Path, seeds: int, jobs: int | None) -> None:
    """Identify both rigs, compare the controllers, count over seeds; the results are in `out`.

    Raises:
        TendondError: no result, a goal missed, a folder that cannot be written.
    """
    need("matplotlib")
    announce_compilation(say)
    warm_up()
    warm_up_trajectories()
    console = Console()
    workers = jobs or len(os.sched_getaffinity(0))
    try:
        out.mkdir(parents=True, exist_ok=True)
        columns = (TextColumn("{task.description:<28}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
        with bars(*columns) as progress:
            proved, summary = validate(out, seeds, workers, progress)
        for task, (_, result) in proved.items():
            for old in (out / task.plant).glob("identified-*.toml"):
                old.unlink()
            console.print(
                f"\nrig '{task.plant}', whose Young's modulus is {truth(task.plant)['E']:.4g} Pa", highlight=False
            )
            print_results(result, write_results(result, out / task.plant, datetime.now(UTC)), console)
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
