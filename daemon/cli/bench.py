"""`tendond bench`: tables of how long things take."""

import json
from pathlib import Path

from rich.console import Console
from rich.table import Table

from tendond.daemon.bench.rod import Row, as_json, bench_rod
from tendond.daemon.bench.schemes import compare_schemes, markdown
from tendond.daemon.cli.common import say
from tendond.daemon.errors import DaemonError
from tendond.model.announce import announce_compilation
from tendond.model.warm import warm_up

MEANING = {
    "euler_n200": "the paper's scheme, 200 nodes",
    "default": "default scheme",
    "default_displacement": "default scheme, displacement-driven",
    "static": "default scheme, statics from the neighbour",
    "reference": "plain NumPy and SciPy, 200 nodes",
}


def run_bench_rod(json_file: Path | None, against: Path | None) -> None:
    """Time the rod's solvers and print the table; see `tendond bench rod --help`.

    Raises:
        DaemonError: a file that cannot be read or written.
    """
    earlier = _read(against) if against is not None else {}
    announce_compilation(say)
    warm_up()
    console = Console()
    with console.status("") as status:
        rows = bench_rod(lambda name: status.update(f"timing {MEANING.get(name, name)}"))
    console.print(_table(rows, earlier))
    if json_file is not None:
        try:
            json_file.parent.mkdir(parents=True, exist_ok=True)
            json_file.write_text(json.dumps(as_json(rows), indent=2) + "\n", encoding="utf-8")
        except OSError as error:
            raise DaemonError(f"{json_file}: cannot be written: {error.strerror}") from error


def run_bench_schemes() -> None:
    """Compare the space schemes and print the table."""
    announce_compilation(say)
    with Console(stderr=True).status("") as status:
        rows = compare_schemes(status.update)
    print(markdown(rows))


def _table(rows: list[Row], earlier: dict[str, float]) -> Table:
    table = Table(title="one step of the rod, 10 ms, four tendons in motion")
    table.add_column("")
    for column in ("median", "p99", "max", "passes", "tip error", "to euler_n200"):
        table.add_column(column, justify="right")
    if earlier:
        table.add_column("to earlier", justify="right")
    euler = next(row.median_us for row in rows if row.name == "euler_n200")
    for row in rows:
        cells = [
            *(f"{value:,.1f} us" for value in (row.median_us, row.p99_us, row.max_us)),
            "-" if row.passes_per_step != row.passes_per_step else f"{row.passes_per_step:.2f}",
            f"{row.tip_error_mm:.4f} mm",
            f"{row.median_us / euler:,.2f}",
        ]
        if earlier:
            cells.append(f"{row.median_us / earlier[row.name]:.2f}" if row.name in earlier else "-")
        table.add_row(f"{row.name}: {MEANING[row.name]}", *cells)
    return table


def _read(path: Path) -> dict[str, float]:
    """Medians by name, of an earlier run."""
    try:
        return {str(row["name"]): float(row["median_us"]) for row in json.loads(path.read_text(encoding="utf-8"))}
    except OSError as error:
        raise DaemonError(f"{path}: cannot be read: {error.strerror}") from error
    except (ValueError, TypeError, KeyError) as error:
        raise DaemonError(f"{path}: is no result of 'tendond bench rod --json'") from error
