"""Prints what the survey of the general rod finds."""

from collections import Counter

from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from tendond.cli.common import say
from tendond.model.numerics.announce import announce_compilation
from tendond.offline.bench.general_rod.survey import Outcome, survey
from tendond.offline.progress import bars


def run_survey(count: int, first: int) -> bool:
    """Run the draws and print those that fail, then a summary; return whether none failed."""
    total: Counter[str] = Counter()

    def note(outcome: Outcome) -> None:
        total.update(split=outcome.split, damped=outcome.damped)
        progress.advance(task)
        if outcome.failed:
            one = outcome.draw
            print(
                f"draw {one.number}: {one.kind}, {one.material}, damping ratio {one.ratio:.4f}, "
                f"time step {one.rod.time_step:.2g} s, length {one.rod.robot.length:.2g} m: {outcome.failed}",
                flush=True,
            )

    announce_compilation(say)
    columns = (TextColumn("draws"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    with bars(*columns) as progress:
        task = progress.add_task("draws", total=count)
        failed = survey(count, first, progress=note)
    print(
        f"{len(failed)} of {count} draws failed; {total['split']} steps were split, "
        f"{total['damped']} parts of steps taken as implicit Euler steps"
    )
    return not failed
