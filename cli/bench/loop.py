"""`tendond bench loop`: the table of the loop's punctuality."""

import json

from rich.console import Console
from rich.table import Table

from tendond.cli.common import say
from tendond.cli.extras import need
from tendond.model.numerics.announce import announce_compilation
from tendond.model.warm import warm_up
from tendond.offline.bench.bare import Quantiles
from tendond.offline.bench.latency import measure_latency
from tendond.offline.bench.punctuality import measure
from tendond.offline.bench.rigs import PunctualityRow
from tendond.offline.progress import working


def run_bench_loop(seconds: float, *, as_json: bool) -> None:
    """Measure and print the table; see `tendond bench loop --help`.

    Raises:
        TendondError: a process could not be started.
    """
    announce_compilation(say)
    warm_up()
    with working("", quiet=as_json) as status:
        rows = measure(seconds, status.update)
    _show(rows, as_json=as_json)


def run_bench_latency(*, as_json: bool) -> None:
    """Measure and print the table; see `tendond bench latency --help`.

    Raises:
        TendondError: a process could not be started.
    """
    announce_compilation(say)
    warm_up()
    with working("", quiet=as_json) as status:
        rows = measure_latency(status.update)
    _show(rows, as_json=as_json)


def run_bench_ros2(*, as_json: bool) -> None:
    """Measure and print the table; see `tendond bench ros2 --help`.

    Raises:
        TendondError: a process could not be started.
    """
    need("rosbags")
    from tendond.offline.bench.ros2 import measure_bridge

    announce_compilation(say)
    warm_up()
    with working("", quiet=as_json) as status:
        rows = [measure_bridge(status.update)]
    _show(rows, as_json=as_json)


def _show(rows: list[PunctualityRow], *, as_json: bool) -> None:
    if not as_json:
        _print(Console(), rows)
        return
    data = [
        {
            "name": row.name,
            "us": row.controller.as_json(),
            "bare_us": row.bare.as_json() if row.bare else None,
            "ratio": row.controller.over(row.bare).as_json() if row.bare else None,
            "note": row.note,
        }
        for row in rows
    ]
    print(json.dumps(data, indent=2))


def _print(console: Console, rows: list[PunctualityRow]) -> None:
    header = ("us", "median", "p99", "p99.9", "bare", "p99", "p99.9", "ratio", "p99", "p99.9", "note")
    lines = []
    for row in rows:
        cells = [row.name, *_three(row.controller, ".0f")]
        cells += [*_three(row.bare, ".0f"), *_three(row.controller.over(row.bare), ".2f")] if row.bare else ["-"] * 6
        lines.append([*cells, row.note])
    if console.is_terminal:
        table = Table()
        for name in header:
            table.add_column(name)
        for line in lines:
            table.add_row(*line)
        console.print(table)
    else:
        print("\n".join("| " + " | ".join(line) + " |" for line in (header, ["---"] * len(header), *lines)))


def _three(value: Quantiles, form: str) -> list[str]:
    return [format(part, form) for part in (value.median, value.p99, value.p999)]
