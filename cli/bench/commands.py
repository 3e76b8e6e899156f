"""The group `tendond bench`: options and help of the benchmarks."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.bench.plants import plants
from tendond.cli.options import Json
from tendond.cli.signals import exit_on_signals

bench = typer.Typer(
    name="bench", help="Benchmark the solvers, the loop and replay.", no_args_is_help=True, rich_markup_mode=None
)


@bench.command("rod")
def bench_rod(
    json: Json = False,
    against: Annotated[Path | None, typer.Option("--against", help="JSON of an earlier run to compare with.")] = None,
    references: Annotated[
        str | None,
        typer.Option(
            "--references",
            metavar="DIR",
            help="Compare the general rod with textbooks and others' data in DIR. '': $TENDOND_REFERENCE_DATA.",
        ),
    ] = None,
    survey: Annotated[
        int | None, typer.Option("--survey", min=1, help="Step this many robots, drawn at random, of the general rod.")
    ] = None,
    first: Annotated[int, typer.Option("--first", min=0, help="Number of the survey's first draw.")] = 0,
    batch: Annotated[
        int | None,
        typer.Option("--batch", metavar="N", min=1, max=1_000_000, help="Step N general rods at once on all cores."),
    ] = None,
) -> None:
    """Benchmark the rod's solvers and their errors.

    With --references, --survey or --batch, the exit status is 1 where a target is missed, a draw fails, or rods that
    are stepped one by one end elsewhere.

    Examples: tendond bench rod --json > before.json; tendond bench rod --against before.json;
    tendond bench rod --references ../data; tendond bench rod --survey 1000; tendond bench rod --batch 2000
    """
    if survey is not None:
        from tendond.cli.bench.survey import run_survey

        raise typer.Exit(0 if run_survey(survey, first) else 1)
    if batch is not None:
        from tendond.cli.bench.batch import run_batch

        raise typer.Exit(0 if run_batch(batch, as_json=json) else 1)
    if references is not None:
        from tendond.cli.bench.references import run_references

        raise typer.Exit(0 if run_references(references, as_json=json) else 1)
    from tendond.cli.bench.tables import run_bench_rod

    run_bench_rod(against, as_json=json)


@bench.command("loop")
def bench_loop(
    seconds: Annotated[float, typer.Option("--seconds", min=1.0, max=3600.0, help="Duration of each run [s].")] = 10.0,
    json: Json = False,
) -> None:
    """Benchmark the control loop against a bare loop.

    Wake-up delay, time of a cycle, pose to command, recorder.

    Real processes on a real bus; takes about six times SECONDS. On a busy machine only the ratios are meaningful.

    Example: tendond bench loop --seconds 5
    """
    exit_on_signals(130)
    from tendond.cli.bench.loop import run_bench_loop

    run_bench_loop(seconds, as_json=json)


@bench.command("latency")
def bench_latency(json: Json = False) -> None:
    """Benchmark the time from a pose to its command, against an echo.

    In lockstep, at any phase of the fixed-rate loop, and with a camera at the loop's rate, phase locked and free.
    Real processes on a real bus; takes about a minute.

    Example: tendond bench latency --json
    """
    exit_on_signals(130)
    from tendond.cli.bench.loop import run_bench_latency

    run_bench_latency(as_json=json)


@bench.command("ros2")
def bench_ros2(json: Json = False) -> None:
    """Benchmark the bridge to ROS 2.

    Times a pose on the bus to the same pose there. Real processes on a real bus; needs the extra
    'ros2' and takes half a minute.

    Example: tendond bench ros2 --json
    """
    exit_on_signals(130)
    from tendond.cli.bench.loop import run_bench_ros2

    run_bench_ros2(as_json=json)


@bench.command("schemes")
def bench_schemes() -> None:
    """Compare space schemes, as a Markdown table.

    Example: tendond bench schemes
    """
    from tendond.cli.bench.tables import run_bench_schemes

    run_bench_schemes()


@bench.command("profiles")
def bench_profiles() -> None:
    """Benchmark both laws on each simulator profile.

    Prints settling and tracking as a Markdown table.

    Example: tendond bench profiles
    """
    from tendond.offline.bench.profiles import table
    from tendond.offline.progress import working

    with working("running both laws on each profile"):
        found = table()
    print(found)


@bench.command("replay")
def bench_replay(
    seconds: Annotated[float, typer.Option("--seconds", min=1.0, max=3600.0, help="Length of the log [s].")] = 20.0,
) -> None:
    """Benchmark replay, as a Markdown table.

    Replays a log made for it (Euler, 200 nodes), next to the cycle's step alone. On a busy machine only the last column
    is meaningful.

    Example: tendond bench replay --seconds 20
    """
    from tendond.cli.bench.tables import run_bench_replay

    run_bench_replay(seconds)


@bench.command("friction")
def bench_friction() -> None:
    """Benchmark tendon friction, as a Markdown table.

    Pulls and releases tendons with friction, and runs both laws with them on profile rig.

    Example: tendond bench friction
    """
    from tendond.offline.bench.friction import table
    from tendond.offline.progress import working

    with working("pulling tendons with friction"):
        found = table()
    print(found)


@bench.command("safety")
def bench_safety(
    repeats: Annotated[int, typer.Option("--repeats", min=2, max=1_000_000, help="Calls of each computation.")] = 2000,
    json: Json = False,
) -> None:
    """Benchmark the safety filter, beside a step of the model.

    Times of this thread, on the paper's robot close to an obstacle.

    Example: tendond bench safety --repeats 10000
    """
    import json as jsons
    from dataclasses import asdict

    from tendond.offline.bench.safety import measure_filter
    from tendond.offline.progress import working

    with working("timing the safety filter", quiet=json):
        costs = measure_filter(repeats)
    if json:
        print(jsons.dumps([asdict(one) for one in costs], indent=2))
        return
    print(f"{'':<26}{'median us':>10}{'p99 us':>10}{'steps':>8}")
    for one in costs:
        print(f"{one.name:<26}{one.median:>10.0f}{one.p99:>10.0f}{one.steps:>8.1f}")


bench.command("plants")(plants)
