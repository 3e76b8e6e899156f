"""`tendond study safety`: robots unlike the model are sent beyond obstacles, with the safety filter and without it."""

import json as jsons
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.options import Json, Processes
from tendond.cli.signals import exit_on_signals


def safety(
    runs: Annotated[int, typer.Option("--runs", min=1, max=1_000_000, help="Number of runs.")] = 40,
    first: Annotated[int, typer.Option("--first", min=0, help="Seed of the first run.")] = 0,
    compared: Annotated[
        int, typer.Option("--compared", min=0, help="One run in so many is made without the filter too; 0: none.")
    ] = 4,
    out: Annotated[Path, typer.Option("--out", help="Folder for the runs; those in it are not run again.")] = Path(
        "out/safety"
    ),
    processes: Processes = None,
    json: Json = False,
) -> None:
    """Send arms beyond obstacles; count those that touch.

    Robots, laws, targets and constraints are drawn from each run's seed, and so is what the model does not know of the
    plant: stiffness, mass, damping, a weight, delay and noise. The true plant is held against the constraints. Exit
    status 1: one broke them, or none did without the filter. Stop it with Ctrl-C, and run it again to go on.

    In lockstep; a run takes about a second.

    Example: tendond study safety --runs 1000 --first 2000
    """
    exit_on_signals(130)

    from tendond.cli.common import say
    from tendond.daemon.errors import DaemonError
    from tendond.model.numerics.announce import announce_compilation
    from tendond.model.warm import warm_up
    from tendond.offline.progress import tracked
    from tendond.offline.safety.campaign import campaign, markdown, meets, read, summary
    from tendond.offline.safety.run import CYCLES

    announce_compilation(say)
    warm_up()
    seeds = range(first, first + runs)
    try:
        some = campaign(seeds, processes, out, compared)
        for _ in tracked(some, runs, "runs", quiet=json):
            pass
        rows = summary([one for one in read(out) if one.seed in seeds], CYCLES)
    except OSError as error:
        raise DaemonError(f"{error.filename or out}: {error.strerror}; choose another folder with --out") from error
    if json:
        print(jsons.dumps([asdict(row) for row in rows], indent=2))
    else:
        print(markdown(rows))
    if not meets(rows):
        raise typer.Exit(1)
