"""`tendond study contact`: forces anywhere on the body, found, located and sized."""

import json
from dataclasses import asdict
from pathlib import Path

from rich.console import Console

from tendond.cli.common import say
from tendond.cli.extras import need
from tendond.daemon.errors import DaemonError
from tendond.model.numerics.announce import announce_compilation
from tendond.model.warm import warm_up
from tendond.offline.contact.report import contact_rows, free_rows, markdown, meets, write
from tendond.offline.contact.study import jobs, run_jobs
from tendond.offline.progress import tracked


def run_contacts(runs: int, minutes: int, seed: int, processes: int | None, out: Path, *, as_json: bool) -> bool:
    """Run the study, print its tables and leave its files in `out`; return whether all targets are met.

    Args:
        runs: of each case with a contact. minutes: of free motion of each case without one.
        seed: first one. processes: parallel ones; none: one per processor. out: folder.
        as_json: print JSON instead of tables.

    Raises:
        TendondError: a robot has no solution, or a folder that cannot be written.
    """
    need("matplotlib")
    announce_compilation(say)
    warm_up()
    some = jobs(runs, minutes, seed)
    watched = tracked(run_jobs(some, processes), len(some), "runs", quiet=as_json)
    outcomes = list(watched)
    rows, free = contact_rows(outcomes), free_rows(outcomes)
    try:
        out.mkdir(parents=True, exist_ok=True)
        write(outcomes, rows, free, out)
        from tendond.offline.contact.figure import draw

        draw(outcomes, out / "contacts.png")
    except OSError as error:
        raise DaemonError(f"{error.filename or out}: {error.strerror}; choose another folder with --out") from error
    if as_json:
        print(json.dumps({"contacts": [asdict(r) for r in rows], "free": [asdict(r) for r in free]}, indent=2))
    else:
        Console().print(markdown(rows, free), soft_wrap=True, highlight=False, markup=False)
    return meets(rows, free)
