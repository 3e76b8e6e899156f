"""`tendond study servo`: the table of the drive's causes of error, and of what the controller says of them."""

import functools
import json
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict

from rich.console import Console

from tendond.cli.common import say
from tendond.model.numerics.announce import announce_compilation
from tendond.model.warm import warm_up
from tendond.offline.drive.cases import cases
from tendond.offline.drive.measure import DriveOutcome, run_case
from tendond.offline.drive.report import markdown, meets
from tendond.offline.progress import tracked


def run_servo_study(period: float, processes: int, *, as_json: bool) -> bool:
    """Run the circle on every chain and print the table; return whether those with all of it configured meet the goals.

    Args:
        period: of the circle [s].
        processes: that run chains.
        as_json: print JSON instead.

    Raises:
        TendondError: a plant has no solution.
    """
    announce_compilation(say)
    warm_up()
    some = cases()
    with ProcessPoolExecutor(processes) as pool:
        running = pool.map(functools.partial(run_case, period=period), some)
        outcomes: list[DriveOutcome] = list(tracked(running, len(some), "chains", quiet=as_json))
    rows = list(zip(some, outcomes, strict=True))
    if as_json:
        print(json.dumps([{"chain": case.name, **asdict(outcome)} for case, outcome in rows], indent=2))
    else:
        Console().print(markdown(rows), soft_wrap=True, highlight=False, markup=False)
    return all(meets(outcome) for case, outcome in rows if case.goal)
