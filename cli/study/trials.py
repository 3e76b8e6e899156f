"""`tendond study robustness --points space`: trajectories in space, with figures, and the task in the plane."""

import functools
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from rich.console import Console
from rich.table import Table

from tendond.cli.common import load_config, say
from tendond.cli.extras import need
from tendond.daemon.errors import DaemonError
from tendond.model.numerics.announce import announce_compilation
from tendond.model.warm import warm_up
from tendond.offline.progress import tracked, working
from tendond.offline.trials.measure import TrialOutcome, planar_task, run_trial
from tendond.offline.trials.paths import Trial, trials
from tendond.offline.trials.report import write

PLANAR_LAWS = ("backstepping", "sliding_mode", "sensitivity")


def run_trials(
    config: Path | None, out: Path, seed: int, jobs: int | None, chosen: Callable[[Trial], bool] = lambda trial: True
) -> None:
    """Run the trajectories and leave table, summary, report and figures in `out`.

    Raises:
        TendondError: an invalid configuration, or a folder that cannot be written.
    """
    need("matplotlib")
    base = load_config(config)
    announce_compilation(say)
    warm_up()
    some, console = [trial for trial in trials(base) if chosen(trial)], Console()
    try:
        out.mkdir(parents=True, exist_ok=True)
        with ProcessPoolExecutor(jobs) as pool:
            running = pool.map(functools.partial(run_trial, base, seed=seed), some)
            outcomes = list(tracked(running, len(some), "trajectories"))
        planar = planar_task(base, PLANAR_LAWS)
        write(some, outcomes, planar, out)
        with working("drawing"):
            from tendond.offline.trials.figure import draw

            for trial, outcome in zip(some, outcomes, strict=True):
                draw(trial, outcome, out / f"{trial.file}.png")
    except OSError as error:
        raise DaemonError(f"{error.filename or out}: {error.strerror}; choose another folder with --out") from error
    console.print(_table(some, outcomes))
    console.print(f"report   {out / 'report.md'}", soft_wrap=True, highlight=False)


def _table(some: list[Trial], outcomes: list[TrialOutcome]) -> Table:
    table = Table(box=None, padding=(0, 1, 0, 0), pad_edge=False)
    for name in ("trajectory", "plant", "RMS mm", "worst mm", "N/cycle", "peak N", "meets"):
        table.add_column(name, justify="left" if name in ("trajectory", "plant") else "right", no_wrap=True)
    for trial, one in zip(some, outcomes, strict=True):
        numbers = (one.rms_mm, one.worst_mm, one.largest_change_n, one.peak_tension_n)
        plant = "unlike" if trial.unlike else "model"
        table.add_row(trial.name, plant, *(f"{value:.2f}" for value in numbers), "yes" if one.meets else "no")
    return table
