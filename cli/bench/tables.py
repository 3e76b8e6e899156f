"""`tendond bench`: the tables of the benchmarks."""

import json
import math
from pathlib import Path

from rich.console import Console
from rich.table import Table

from tendond.cli.common import say
from tendond.daemon.errors import DaemonError
from tendond.model.numerics.announce import announce_compilation
from tendond.model.warm import warm_up
from tendond.offline.bench.general_rod.timing import GeneralRow, bench_general
from tendond.offline.bench.replay import bench_replay
from tendond.offline.bench.replay import markdown as replay_table
from tendond.offline.bench.rod import RodRow, bench_rod
from tendond.offline.bench.rod import as_json as rows_as_json
from tendond.offline.bench.schemes import compare_schemes, markdown
from tendond.offline.progress import working

MEANING = {
    "euler_n200": "paper's scheme",
    "default": "rk6, 6 nodes",
    "default_displacement": "elastic tendons",
    "static": "from a neighbour",
    "reference": "plain SciPy, euler",
}


DIGITS = (1, 1, 2, 2)
"""Decimals in the columns of the general rod's table."""


def run_bench_rod(against: Path | None, *, as_json: bool) -> None:
    """Time the rod's solvers and print the table; see `tendond bench rod --help`.

    Raises:
        DaemonError: a file that cannot be read.
    """
    earlier = _read(against) if against is not None else {}
    announce_compilation(say)
    warm_up()
    console = Console()
    with working("", quiet=as_json) as status:
        rows = bench_rod(lambda name: status.update(f"timing {MEANING.get(name, name)}"))
        general = bench_general(lambda name: status.update(f"timing {name}"))
    if as_json:
        print(json.dumps([*rows_as_json(rows), *rows_as_json(general)], indent=2))
        return
    print_table(console, *_cells(rows, earlier))
    console.print()
    print_table(console, *_general_cells(general, earlier))


def print_table(console: Console, header: list[str], lines: list[list[str]], left: int = 1) -> None:
    """Print a table; as Markdown where the output is no terminal. The first `left` columns are words."""
    if not console.is_terminal:
        print("\n".join("| " + " | ".join(line) + " |" for line in (header, ["---"] * len(header), *lines)))
        return
    table = Table()
    for index, name in enumerate(header):
        table.add_column(name, justify="left" if index < left else "right")
    for line in lines:
        table.add_row(*line)
    console.print(table)


def run_bench_schemes() -> None:
    """Compare the space schemes and print the table."""
    announce_compilation(say)
    with working("") as status:
        rows = compare_schemes(status.update)
    print(markdown(rows))


def run_bench_replay(seconds: float) -> None:
    """Time replays and print the table; see `tendond bench replay --help`."""
    announce_compilation(say)
    with working("") as status:
        rows = bench_replay(seconds, status.update)
    print(replay_table(rows))


def _cells(rows: list[RodRow], earlier: dict[str, float]) -> tuple[list[str], list[list[str]]]:
    """Format header and lines of the table."""
    header = ["one step, 10 ms", "median us", "p99 us", "max us", "passes", "tip error mm", "to euler_n200"]
    euler = next(row.median_us for row in rows if row.name == "euler_n200")
    lines = [
        [
            f"{row.name}: {MEANING[row.name]}",
            *(f"{value:.0f}" for value in (row.median_us, row.p99_us, row.max_us)),
            "-" if math.isnan(row.passes_per_step) else f"{row.passes_per_step:.2f}",
            f"{row.tip_error_mm:.4f}",
            f"{row.median_us / euler:.2f}",
        ]
        for row in rows
    ]
    if earlier:
        header.append("to earlier")
        for row, line in zip(rows, lines, strict=True):
            line.append(f"{row.median_us / earlier[row.name]:.2f}" if row.name in earlier else "-")
    return header, lines


def _general_cells(rows: list[GeneralRow], earlier: dict[str, float]) -> tuple[list[str], list[list[str]]]:
    """Format header and lines of the table of the general rod."""
    header = ["general rod", "median us", "p99 us", "to shooting rod", "to a step of 10 ms"]
    numbers = [(row.median_us, row.p99_us, row.to_shooting, row.to_step) for row in rows]
    lines = [
        [
            row.name,
            *("-" if math.isnan(one) else f"{one:.{digits}f}" for one, digits in zip(cells, DIGITS, strict=True)),
        ]
        for row, cells in zip(rows, numbers, strict=True)
    ]
    if earlier:
        header.append("to earlier")
        for row, line in zip(rows, lines, strict=True):
            line.append(f"{row.median_us / earlier[row.name]:.2f}" if row.name in earlier else "-")
    return header, lines


def _read(path: Path) -> dict[str, float]:
    """Read the medians of an earlier run, by name."""
    try:
        return {str(row["name"]): float(row["median_us"]) for row in json.loads(path.read_text(encoding="utf-8"))}
    except OSError as error:
        raise DaemonError(f"{path}: cannot be read: {error.strerror}") from error
    except (ValueError, TypeError, KeyError) as error:
        raise DaemonError(f"{path}: is not a result of 'tendond bench rod --json'") from error
