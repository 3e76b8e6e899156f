"""Experiments in simulation: their options and their help; what they do stands in the modules that they import."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.options import Config
from tendond.cli.signals import leave_on_signals


def demo(
    out: Annotated[Path, typer.Option("--out", help="Folder for log, figures and summary.")] = Path("out/demo"),
    profile: Annotated[str, typer.Option("--profile", help="paper, rig or nasty, see docs/simulator.md.")] = "paper",
) -> None:
    """Simulate the paper's experiment, with log and figures.

    Controller and simulator are two processes on Zenoh, in real time; takes about ten seconds.

    Example, with the servos' real speed: tendond demo --profile rig --out out/demo-rig
    """
    leave_on_signals(130)
    from tendond.cli.demo.demo import run_demo

    run_demo(out, profile)


def paper(
    out: Annotated[Path, typer.Option("--out", help="Folder for page, tables and figures.")] = Path("out/paper"),
    processes: Annotated[
        int | None, typer.Option("--processes", min=1, help="To share the work. Left out: one per processor.")
    ] = None,
) -> None:
    """Reproduce the paper: simulations, tables and figures.

    Every one, with its numbers beside the paper's.

    Offline, in lockstep; takes about a minute.

    Example: tendond paper --out out/paper
    """
    leave_on_signals(130)
    from tendond.cli.study.paper import run_paper

    run_paper(out, processes)


def robustness(
    config: Config = None,
    out: Annotated[Path, typer.Option("--out", help="Folder for table, summary, figure and report.")] = Path(
        "out/robustness"
    ),
    points: Annotated[
        str, typer.Option("--points", help="Which plants: default, axes, corners, grid, sample; or space.")
    ] = "default",
    law: Annotated[list[str] | None, typer.Option("--law", help="Only this law; may be repeated.")] = None,
    feedback: Annotated[
        list[str] | None, typer.Option("--feedback", help="Only force, offset or direct; may be repeated.")
    ] = None,
    count: Annotated[
        int | None, typer.Option("--count", min=1, max=1_000_000, help="Random points per law. Left out: 50.")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of noise and random points.")] = 0,
    jobs: Annotated[
        int | None, typer.Option("--jobs", "-j", min=1, max=1024, help="Processes. Left out: one per core.")
    ] = None,
    cluster: Annotated[
        str | None, typer.Option("--cluster", help="Dask scheduler to run on instead, for instance tcp://HOST:8786.")
    ] = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="Leave aside the results that the folder has.")] = False,
) -> None:
    """Run the closed loop on plants that differ from the model.

    In delay, lag, noise, stiffness, loads, impacts.

    axes: one thing at a time, for every feedback; corners: all extremes together; grid: every combination (an hour);
    sample: random plants; default: all but the grid. The plant is the configuration's [rod], changed.

    space: instead, circles, figure-eight, helix and line with the law 'sensitivity', a figure each; half a minute.

    The default set takes about two minutes on two cores. Interrupted, the same command goes on where it was.

    Example: tendond robustness --points axes --feedback force
    """
    leave_on_signals(130)
    from tendond.cli.study.robustness import run_robustness
    from tendond.offline.robustness.points import FEEDBACKS, POINT_SETS, SAMPLE_SIZE

    if points == "space":
        if law not in (None, ["sensitivity"]) or feedback or count or cluster or fresh:
            raise typer.BadParameter("'space' runs the law sensitivity alone, anew, here", param_hint="--points")
        from tendond.cli.study.trials import run_trials

        run_trials(config, out, seed, jobs)
        return
    if points not in POINT_SETS:
        raise typer.BadParameter(f"'{points}': choose one of {', '.join(POINT_SETS)}, space", param_hint="--points")
    for name in feedback or ():
        if name not in FEEDBACKS:
            raise typer.BadParameter(f"'{name}': choose among {', '.join(FEEDBACKS)}", param_hint="--feedback")
    if count is not None and points not in ("default", "sample"):
        raise typer.BadParameter(f"the set '{points}' has no random points", param_hint="--count")
    run_robustness(
        config,
        out,
        points,
        tuple(law or ("backstepping", "sliding_mode")),
        tuple(feedback) if feedback else None,
        count=SAMPLE_SIZE if count is None else count,
        seed=seed,
        jobs=jobs,
        cluster=cluster,
        fresh=fresh,
    )


def rig_demo(
    out: Annotated[Path, typer.Option("--out", help="Folder for log, figures and summary.")] = Path("out/rig-demo"),
) -> None:
    """Simulate the robot behind its real drivers.

    Servos on a serial line, Tracker on UDP; takes half a minute.

    Example: tendond rig-demo --out out/rig-demo
    """
    leave_on_signals(130)
    from tendond.cli.demo.demo import run_rig_demo

    run_rig_demo(out)


def demo_3d(
    out: Annotated[Path, typer.Option("--out", help="Folder for logs, figures and summary.")] = Path("out/demo-3d"),
) -> None:
    """Simulate a circle of the tip in space.

    All four tendons pull: once with tensions as commanded, once behind the real drivers; takes about a minute.

    Example: tendond demo-3d --out out/demo-3d
    """
    leave_on_signals(130)
    from tendond.cli.demo.spatial import run_space_demo

    run_space_demo(out)


def add_to(app: typer.Typer) -> None:
    """Add the commands of this module."""
    for command in (demo, paper, robustness):
        app.command()(command)
    app.command("rig-demo")(rig_demo)
    app.command("demo-3d")(demo_3d)
