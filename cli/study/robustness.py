"""`tendond study robustness`: the closed loop on plants that differ from the model."""

import functools
import json
import os
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from tendond.cli.common import load_config, say
from tendond.cli.extras import need
from tendond.daemon.errors import DaemonError
from tendond.model.numerics.announce import announce_compilation
from tendond.model.warm import warm_up
from tendond.offline.files import write_whole
from tendond.offline.progress import bars, working
from tendond.offline.robustness.executors import check_cluster_extra, in_processes, on_cluster
from tendond.offline.robustness.report import report as report_page
from tendond.offline.robustness.run import Executor, Rows, run
from tendond.offline.robustness.settings import Settings
from tendond.offline.robustness.summary import GOAL, counts, groups, removed, summary

FILES = {"results": "results.csv", "summary": "summary.json", "report": "report.md", "figure": "heatmap.png"}


def run_robustness(
    config: Path | None,
    out: Path,
    points: str,
    laws: tuple[str, ...],
    feedbacks: tuple[str, ...] | None,
    *,
    count: int,
    seed: int,
    jobs: int | None,
    cluster: str | None,
    fresh: bool,
    open_loop: bool,
) -> None:
    """Run the points and leave the results in `out`; see `tendond study robustness --help`.

    Raises:
        TendondError: invalid options, a folder that cannot be written, a cluster that cannot be reached.
    """
    need("matplotlib")
    if cluster is not None:
        check_cluster_extra()
    settings = Settings(points, count, seed, laws, feedbacks, load_config(config))
    announce_compilation(say)
    warm_up()  # here once, so that the workers find the kernels in the cache
    execute: Executor = (
        functools.partial(in_processes, jobs=jobs or len(os.sched_getaffinity(0)))
        if cluster is None
        else functools.partial(on_cluster, address=cluster)
    )
    console = Console()
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[missed]} miss the goal"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    counted = [0, 0]
    try:
        with bars(*columns) as progress:
            task = progress.add_task("points", total=None, missed=0)

            def report(done: int, total: int, missed: int) -> None:
                counted[:] = done, total
                progress.update(task, completed=done, total=total, missed=missed)

            threads = (jobs or len(os.sched_getaffinity(0))) if open_loop else 0
            rows = run(settings, out, execute, report, fresh=fresh, open_loop_threads=threads)
        _write(rows, settings, out, console)
    except (SystemExit, KeyboardInterrupt):
        if counted[1]:
            say(f"interrupted: {counted[0]} of {counted[1]} points are kept in {out}; run the same command to resume")
        raise
    except OSError as error:
        raise DaemonError(f"{error.filename or out}: {error.strerror}; choose another folder with --out") from error
    console.print(_table(rows))
    if open_loop:
        console.print(_errors_table(rows))
    files = "\n".join(f"{name:<8} {out / file}" for name, file in FILES.items())
    console.print(f"goal     {GOAL}\n{files}", soft_wrap=True, highlight=False)


def _write(rows: Rows, settings: Settings, out: Path, console: Console) -> None:
    """Write summary, report and figure."""
    values = settings.as_json()
    write_whole(out / FILES["summary"], json.dumps(summary(rows, values), indent=2) + "\n")
    write_whole(out / FILES["report"], report_page(rows, values))
    with working("drawing"):
        from tendond.offline.robustness.figure import draw

        draw(rows, out / FILES["figure"])


def _table(rows: Rows) -> Table:
    """Tabulate how many points meet the goal."""
    table = Table(box=None, padding=(0, 1, 0, 0), pad_edge=False)
    names = (
        "law",
        "feedback",
        "misconfigured",
        "points",
        "meet",
        "fault",
        "slow",
        "ripple",
        "tension",
        "impact",
    )
    for name in names:
        table.add_column(name, justify="left" if name in names[:3] else "right", no_wrap=True)
    for misconfigured in (False, True):
        for (law, feedback), part in groups(rows, misconfigured=misconfigured).items():
            numbers = (str(value) for value in counts(part).values())
            table.add_row(law.replace("_", " "), feedback, "wrong" if misconfigured else "right", *numbers)
    return table


def _errors_table(rows: Rows) -> Table:
    """Tabulate the tip's steady errors without feedback and with it."""
    table = Table(box=None, padding=(0, 1, 0, 0), pad_edge=False, title="steady error [mm]", title_justify="left")
    for name in ("law", "feedback", "open loop", "95 %", "worst", "closed loop", "95 %", "worst"):
        table.add_column(name, justify="left" if name in ("law", "feedback") else "right", no_wrap=True)
    for (law, feedback), part in groups(rows).items():
        found = removed(part)
        values = (
            [found[loop][key] for loop in ("open_loop", "closed_loop") for key in ("median", "p95", "worst")]
            if found
            else []
        )
        table.add_row(law.replace("_", " "), feedback, *(f"{value:.3g}" for value in values))
    return table
