"""`tendond log replay` and `tendond log what-if`."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

from rich.console import Console
from rich.table import Table

from tendond.cli.common import say
from tendond.daemon.recording.run_files import part_path
from tendond.model.numerics.announce import announce_compilation
from tendond.offline.logs.run import open_run
from tendond.offline.logs.ticks import shown
from tendond.offline.progress import working
from tendond.offline.replay.changes import parameter_changes, version_changes, with_changes
from tendond.offline.replay.rerun import ReplayOutcome, rerun
from tendond.offline.replay.variant import Commanded, closed_loop, same_inputs

SHOWN_FIELDS = 40


def run_replay(
    file: Path, first: int, last: int | None, tolerance: float | None, jobs: int | None, *, as_json: bool
) -> None:
    """Replay and print the verdict; see `tendond replay --help`.

    Raises:
        LogError: the log cannot be used.
        SystemExit: with 1, a cycle differs.
    """
    run = open_run(file)
    announce_compilation(say)
    changes = version_changes(run) + parameter_changes(run)
    if not as_json:
        for line in changes:
            print(f"changed: {line}")
    with working(f"replaying {file.name}", quiet=as_json):
        outcome = rerun(file, first=first, last=last, tolerance=tolerance, jobs=jobs)
    if as_json:
        print(
            json.dumps({**asdict(outcome), "equal": outcome.first is None, "changed": changes}, indent=2, default=str)
        )
        if outcome.first is not None:
            raise SystemExit(1)
        return
    _print_gaps(outcome)
    cycles = f"{outcome.compared} cycles ({outcome.compared * outcome.period:.1f} s)"
    rate = f"{outcome.seconds:.2f} s, {outcome.speed:.0f} times real time"
    if outcome.first is None:
        how = "bit-identical" if tolerance is None else f"equal within {tolerance:g}"
        print(f"{cycles} replayed: {how} ({rate})")
        return
    print(f"first differing cycle: {outcome.first.tick}")
    for field in outcome.first.fields[:SHOWN_FIELDS]:
        print(f"  {field}")
    if len(outcome.first.fields) > SHOWN_FIELDS:
        print(f"  and {len(outcome.first.fields) - SHOWN_FIELDS} more fields")
    print(f"{cycles} replayed: {outcome.differing} differ ({rate})")
    if tolerance is None and any(line.startswith("processor") for line in changes):
        print("the log is from another CPU: --tolerance 1e-3 allows for its rounding")
    raise SystemExit(1)


def run_variant(
    file: Path, law: str | None, changes: list[str], out: Path | None, *, closed_loop: bool, as_json: bool
) -> None:
    """Run with a change, write the new log, and print how its commands differ.

    Raises:
        UsageError: an invalid change, or a log that cannot be used.
    """
    config = with_changes(open_run(file).config, law, changes)
    words = [*([f"control.law={law}"] if law else []), *changes]
    out = out or file.with_name(f"{file.stem}-{'closed-loop' if closed_loop else 'same-inputs'}.mcap")
    announce_compilation(say)
    run = _closed_loop if closed_loop else same_inputs
    with _none_of_it_if_it_fails(out), working(f"running {file.name} again", quiet=as_json):
        found = run(file, config, out, " ".join(words))
    if as_json:
        print(json.dumps({**asdict(found), "log": str(out)}, indent=2))
        return
    Console().print(_table(found, "closed loop" if closed_loop else "same inputs"))
    print(f"log  {out}")


_closed_loop = closed_loop


@contextmanager
def _none_of_it_if_it_fails(log: Path) -> Iterator[None]:
    """Remove every part of a new log that is not finished: of a run it would be evidence, of a what-if it misleads."""
    existed = log.exists()  # then it is refused, and stays
    try:
        yield
    except BaseException:
        part, number = log, 0
        while not existed and part.is_file():
            part.unlink()
            part, number = part_path(log, number + 1), number + 1
        raise


def _print_gaps(outcome: ReplayOutcome) -> None:
    for a, b in outcome.gaps.missing:
        print(f"missing: {shown((a, b))}, not in the log")
    if outcome.gaps.left_out:
        print(f"omitted while idle: {outcome.gaps.left_out} cycles (log.idle_period)")
    if outcome.gaps.passed_over:
        print(f"not compared: {outcome.gaps.passed_over} cycles before the next state in the log")
    if not outcome.complete:
        print("incomplete: the end of the log is missing (its writer was killed, or the disk was full)")


def _table(found: Commanded, title: str) -> Table:
    table = Table(title=f"commands, new minus recorded ({title})", show_header=True)
    for name in ("", "unit", "rms", "largest"):
        table.add_column(name, justify="right" if name in ("rms", "largest") else "left")
    table.add_row("tension", "N", f"{found.tension_rms:.4g}", f"{found.tension_max:.4g}")
    millimetres = (f"{1e3 * found.displacement_rms:.4g}", f"{1e3 * found.displacement_max:.4g}")
    table.add_row("displacement", "mm", *millimetres)
    table.add_row("other mode", f"of {found.cycles} cycles", "", str(found.modes))
    return table
