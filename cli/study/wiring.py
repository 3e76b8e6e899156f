"""`tendond study wiring`: the table of miswired and correct rigs."""

import json
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

from rich.console import Console
from rich.table import Table

from tendond.cli.common import say
from tendond.daemon.errors import DaemonError
from tendond.model.numerics.announce import announce_compilation
from tendond.model.warm import warm_up
from tendond.offline.files import write_whole
from tendond.offline.progress import tracked
from tendond.offline.wiring.report import WiringRow, markdown, rows
from tendond.offline.wiring.study import RIGHT, Job, WiringOutcome, jobs, laws, run_study


def run_wiring(
    chosen: tuple[str, ...],
    setups: int,
    groups: tuple[str, ...],
    processes: int | None,
    out: Path | None,
    *,
    as_json: bool,
) -> bool:
    """Run the study and print the table; return whether every row passes.

    Args:
        chosen: laws.
        setups: number of correct rigs.
        groups: rows; empty: all.
        processes: parallel processes; none: one per processor.
        out: file for the table as Markdown.
        as_json: print JSON.

    Raises:
        DaemonError: no such row, or the file cannot be written.
    """
    announce_compilation(say)
    warm_up()
    work = list(jobs(chosen or laws(), setups, groups or None))
    if not work:
        raise DaemonError(f"no such row: {', '.join(groups)}; without --row all are run")
    table = rows(_watched(work, processes, silent=as_json))
    if out is not None:
        try:
            out.parent.mkdir(parents=True, exist_ok=True)
            write_whole(out, markdown(table))
        except OSError as error:
            raise DaemonError(f"{out}: {error.strerror}; choose another file with --out") from error
    if as_json:
        print(json.dumps([{**asdict(row), "holds": row.holds} for row in table], indent=2))
    else:
        _print(table)
    return all(row.holds for row in table)


def _watched(work: list[Job], processes: int | None, *, silent: bool) -> Iterator[WiringOutcome]:
    yield from tracked(run_study(work, processes), len(work), "runs", quiet=silent)


def _print(table: list[WiringRow]) -> None:
    shown = Table(title="miswired and correct rigs")
    for name in (
        "chain",
        "mistake",
        "runs",
        "refused",
        "fault",
        "missed",
        "latest [s]",
        "tip [% L]",
        "pulled [%]",
    ):
        shown.add_column(name, justify="left" if name in ("chain", "mistake") else "right")
    for row in table:
        right = row.group == RIGHT
        shown.add_row(
            row.chain, "nothing" if right else row.group, str(row.runs), str(row.refused), str(row.faulted),
            str(row.missed), f"{row.seconds:.1f}", "" if right else f"{100 * row.moved:.1f}",
            "" if right else f"{100 * row.pulled:.1f}", style=None if row.holds else "red",
        )  # fmt: skip
    console = Console()
    console.print(shown)
    for row in table:
        if not row.holds:
            console.print(f"{row.chain}, {row.group}: {row.worst}", markup=False)
