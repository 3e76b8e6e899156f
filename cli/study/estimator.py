"""`tendond study estimator`: the table and the filter's cost; with `--loop`, loops with it and with fixed gains."""

import functools
import json
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from itertools import product

from rich.console import Console

from tendond.cli.common import say
from tendond.model.numerics.announce import announce_compilation
from tendond.model.strain.describe.configured import described
from tendond.model.warm import warm_up, warm_up_filter, warm_up_general
from tendond.offline.estimator.cost import cost_of, in_sections
from tendond.offline.estimator.loop.cases import KINDS, LAWS, PLANTS, Kind, Plant
from tendond.offline.estimator.loop.measure import LoopRun, missed, run_loop
from tendond.offline.estimator.loop.measure import markdown as loop_table
from tendond.offline.estimator.runs import Unlike, noise_for, run_one
from tendond.offline.estimator.summary import CASES, markdown, summarise
from tendond.offline.progress import tracked


def run_estimator_study(
    name: str,
    runs: int,
    first: int,
    processes: int,
    tension_error: tuple[float, float],
    *,
    matched: bool,
    as_json: bool,
) -> bool:
    """Run all cases, and print the table; return whether every goal is met.

    Args:
        name: of a preset, or a file. runs: number of seeds. first: of them. processes: that run them.
        tension_error: of the filter's noise [-], and the time over which it changes [s].
        matched: the robots are like the model. as_json: print JSON instead.

    Raises:
        ConfigError: no such robot.
        TendondError: a plant has no solution.
    """
    robot, _ = described(name)
    announce_compilation(say)
    warm_up()
    warm_up_general()
    warm_up_filter()
    costs = [cost_of(f"{count} section{'s' * (count > 1)}", in_sections(robot, count)) for count in (1, 3)]
    unlike, noise = Unlike.like() if matched else Unlike(), noise_for(robot, *tension_error)
    summaries = []
    with ProcessPoolExecutor(processes) as pool:
        for case in CASES:
            run = functools.partial(run_one, robot, case, unlike=unlike, noise=noise)
            running = pool.map(run, range(first, first + runs), chunksize=4)
            found = list(tracked(running, runs, f"{case.name}: runs", quiet=as_json))
            summaries.append(summarise(case, found, robot.length))
    if as_json:
        rows = [asdict(one) | {"missed": one.missed} for one in summaries]
        print(json.dumps({"cases": rows, "cost": [asdict(one) for one in costs]}, indent=2))
    else:
        console = Console()
        console.print(markdown(summaries, robot.length), soft_wrap=True, highlight=False, markup=False)
        for one in costs:
            print(
                f"{one.robot}: {one.filter:.0f} us a cycle for {one.errors} errors, beside a step of {one.step:.0f} us"
            )
    return not any(one.missed for one in summaries)


def run_loop_study(processes: int, *, as_json: bool) -> bool:
    """Run all, and print the table; return whether the filter's loops settle wherever those with fixed gains do.

    Raises:
        TendondError: a reference cannot be followed.
    """
    with ProcessPoolExecutor(processes) as pool:
        some = list(product(PLANTS, LAWS, KINDS))
        runs = list(tracked(pool.map(_loop, some), len(some), "loops", quiet=as_json))
    wrong = missed(runs)
    if as_json:
        print(json.dumps({"runs": [asdict(one) for one in runs], "missed": wrong}, indent=2))
    else:
        print(loop_table(runs))
        print("\nmissed: " + "; ".join(wrong) if wrong else "\nAll goals are met.")
    return not wrong


def _loop(given: tuple[Plant, str, Kind]) -> LoopRun:
    return run_loop(*given)
