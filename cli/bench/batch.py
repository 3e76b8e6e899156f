"""`tendond bench rod --batch`: many rods at once."""

import json
from dataclasses import asdict

from rich.console import Console

from tendond.cli.bench.tables import print_table
from tendond.cli.common import say
from tendond.model.numerics.announce import announce_compilation
from tendond.offline.bench.general_rod.batch import GOAL_RODS, GOAL_SECONDS, bench_batch
from tendond.offline.progress import working


def run_batch(rods: int, *, as_json: bool) -> bool:
    """Time 1 s of motion of many rods and print the figures; return whether rods one by one end in the same bits."""
    announce_compilation(say)
    with working(f"stepping {rods} rods", quiet=as_json):
        row = bench_batch(rods)
    if as_json:
        print(json.dumps(asdict(row), indent=2))
        return row.equal
    header = [
        "1 s of 10 ms steps",
        "threads",
        "s",
        "us a step, processor",
        f"s for {GOAL_RODS}",
        "goal s",
        "with friction",
        "base moves",
        "bits as one by one",
    ]
    line = [
        f"{row.rods} rods", str(row.threads), f"{row.seconds:.2f}", f"{row.step_us:.1f}", f"{row.goal_seconds:.0f}",
        f"{GOAL_SECONDS:.0f}", f"x {row.friction_ratio:.2f}", f"x {row.base_ratio:.2f}", "yes" if row.equal else "NO",
    ]  # fmt: skip
    print_table(Console(), header, [line])
    return row.equal
