"""The group `tendond study`: options and help of the studies on simulated rigs."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.completion import feedbacks, laws, point_sets
from tendond.cli.figure_options import FigureStyle, Font, Formats, Iterations, Width, appearance_of
from tendond.cli.options import Config, Jobs, Json, Processes
from tendond.cli.signals import exit_on_signals
from tendond.cli.study.estimator_command import estimator
from tendond.cli.study.sections import sections

study = typer.Typer(
    name="study",
    help="Reproduce the paper, test robustness, identify the model.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


def processor_count() -> int:
    """Count the processors that this process may use."""
    import os

    return len(os.sched_getaffinity(0))


@study.command("paper")
def paper(
    out: Annotated[Path, typer.Option("--out", help="Folder for page, tables and figures.")] = Path("out/paper"),
    processes: Processes = None,
    format: Formats = "png",
    style: FigureStyle = "default",
    width: Width = None,
    font: Font = None,
    iterations: Iterations = False,
) -> None:
    """Reproduce the paper's simulations.

    Every table and figure, next to the published numbers. In lockstep; a minute. Replaces earlier results.

    Example: tendond study paper --out out/paper
    """
    exit_on_signals(130)
    from tendond.cli.study.paper import run_paper
    from tendond.offline.plots.appearance import parse_formats

    run_paper(out, processes, appearance_of(parse_formats(format), style, width, font, iterations=iterations))


@study.command("robustness")
def robustness(
    config: Config = None,
    out: Annotated[Path, typer.Option("--out", help="Folder for table, summary, figure and report.")] = Path(
        "out/robustness"
    ),
    points: Annotated[
        str,
        typer.Option(
            "--points",
            help="Set of plants: default, axes, corners, grid, sample, or space.",
            autocompletion=point_sets,
        ),
    ] = "default",
    law: Annotated[
        list[str] | None, typer.Option("--law", help="Control law; may be repeated.", autocompletion=laws)
    ] = None,
    feedback: Annotated[
        list[str] | None,
        typer.Option("--feedback", help="force, offset or direct; may be repeated.", autocompletion=feedbacks),
    ] = None,
    count: Annotated[
        int | None, typer.Option("--count", min=1, max=1_000_000, help="Random points per law. Default: 50.")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of noise and random points.")] = 0,
    jobs: Jobs = None,
    cluster: Annotated[
        str | None, typer.Option("--cluster", help="Dask scheduler to run on instead, such as tcp://HOST:8786.")
    ] = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="Discard the results already in the folder.")] = False,
    open_loop: Annotated[
        bool,
        typer.Option("--open-loop", help="Compare with the nominal run's tendon commands on each plant, no feedback."),
    ] = False,
) -> None:
    """Run the loop on plants that differ from the model.

    In delay, lag, noise, stiffness, loads and impacts. The plant is the configuration's [rod], changed.

    axes: one parameter at a time, for every feedback; corners: all extremes together; grid: every combination (an
    hour); sample: random plants; default: all but the grid (about two minutes on two cores). space: circles,
    figure-eight, helix and line with the law 'sensitivity', a figure each (half a minute).

    An interrupted study can be resumed with the same command. --open-loop adds what the feedback removes: the tip's
    steady error of each plant under the tendon commands of the nominal run, all plants stepped at once as general rods.

    Example: tendond study robustness --points axes --feedback force
    """
    from tendond.schemas.errors.explain import choose

    exit_on_signals(130)
    from tendond.cli.study.robustness import run_robustness
    from tendond.offline.robustness.points import FEEDBACKS, POINT_SETS, SAMPLE_SIZE

    if points == "space":
        if law not in (None, ["sensitivity"]) or feedback or count or cluster or fresh or open_loop:
            raise typer.BadParameter(
                "'space' takes no --feedback, --count, --cluster, --fresh, --open-loop, and no law but sensitivity",
                param_hint="--points",
            )
        from tendond.cli.study.trials import run_trials

        run_trials(config, out, seed, jobs)
        return
    if points not in POINT_SETS:
        raise typer.BadParameter(f"'{points}': {choose(points, [*POINT_SETS, 'space'])}", param_hint="--points")
    for name in feedback or ():
        if name not in FEEDBACKS:
            raise typer.BadParameter(f"'{name}': {choose(name, FEEDBACKS)}", param_hint="--feedback")
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
        open_loop=open_loop,
    )


@study.command("margin")
def margin(
    config: Config = None,
    json: Json = False,
    short: Annotated[bool, typer.Option("--short", help="Run the extreme cases at 100 Hz only.")] = False,
    observer: Annotated[
        str | None, typer.Option("--observer", help="kalman: the filter on the general rod. Default: as configured.")
    ] = None,
    processes: Processes = None,
) -> None:
    """Compute the loop's stability margin for a tip mass.

    Prints the gains that the margin admits, the stiffness of the bent arm, and lockstep runs with tip masses unknown
    to the controller. Exit status 1: a run does not settle, or its ripple exceeds 0.2 mm.

    With observer.kind = "kalman", or --observer kalman, it prints the poles of the loop with the filter instead, for
    each law, from 50 to 500 Hz, with delays, bent and nearly straight; the worst of plants with another stiffness, an
    unknown mass on the tip and a cycle of delay more. Exit status 1: a motion grows.

    Example: tendond study margin --short
    """
    exit_on_signals(130)
    from tendond.cli.common import load_config
    from tendond.cli.study.margin import run_filter_margin, run_margin

    if observer not in (None, "kalman"):
        raise typer.BadParameter(f"'{observer}': only kalman can be chosen", param_hint="--observer")
    if observer == "kalman" or load_config(config).observer.kind == "kalman":
        if not run_filter_margin(config, json, short, processes or processor_count()):
            raise typer.Exit(1)
        return
    if not run_margin(config, json, short, processes or processor_count()):
        raise typer.Exit(1)


@study.command("servo")
def servo(
    period: Annotated[float, typer.Option("--period", min=1.0, max=60.0, help="Period of the circle [s].")] = 4.0,
    processes: Processes = None,
    json: Json = False,
) -> None:
    """Take the drive's error apart by its causes.

    A circle in space, with the servos' steps, backlash, profile and lag, the tendons' friction, the pose's delay and
    noise: each alone, all together, and all with what the configuration says of them, right or wrong; in lockstep,
    about a minute. Exit status 1: a chain of which everything is configured misses a goal.

    Example: tendond study servo --period 2
    """
    exit_on_signals(130)
    from tendond.cli.study.servo import run_servo_study

    if not run_servo_study(period, processes or processor_count(), as_json=json):
        raise typer.Exit(1)


study.command("estimator")(estimator)


@study.command("wiring")
def wiring(
    law: Annotated[
        list[str] | None, typer.Option("--law", help="Control law; may be repeated.", autocompletion=laws)
    ] = None,
    row: Annotated[list[str] | None, typer.Option("--row", help="Kind of mistake; may be repeated.")] = None,
    setups: Annotated[
        int, typer.Option("--setups", min=0, max=1_000_000, help="Number of correct rigs, drawn at random.")
    ] = 100,
    processes: Processes = None,
    out: Annotated[Path | None, typer.Option("--out", help="Markdown file for the table.")] = None,
    json: Json = False,
) -> None:
    """Arm miswired rigs, and correct ones.

    Mistakes of the camera's frame, units and quaternions, of the tendons' order, sign and spools, poses of another
    robot and stale ones, for each law, with ideal tendons and with servos. A row passes if every miswired rig is
    refused, or faults before the tip has moved far, and no correct rig does. Exit status 1: a row fails.

    In lockstep; takes several minutes.

    Example: tendond study wiring --setups 1000 --out out/wiring.md
    """
    from tendond.schemas.errors.explain import choose

    exit_on_signals(130)
    from tendond.cli.study.wiring import run_wiring
    from tendond.daemon.control.laws import LAWS

    for name in law or ():
        if name not in LAWS:
            raise typer.BadParameter(f"'{name}': {choose(name, LAWS)}", param_hint="--law")
    if not run_wiring(tuple(law or ()), setups, tuple(row or ()), processes, out, as_json=json):
        raise typer.Exit(1)


@study.command("contact")
def contact(
    runs: Annotated[int, typer.Option("--runs", min=1, max=100_000, help="Runs of each case with a contact.")] = 30,
    minutes: Annotated[
        int, typer.Option("--minutes", min=0, max=100_000, help="Minutes of free motion of each robot.")
    ] = 10,
    seed: Annotated[int, typer.Option("--seed", min=0, help="First seed.")] = 0,
    out: Annotated[Path, typer.Option("--out", help="Folder for table, summary, figure and report.")] = Path(
        "out/contact"
    ),
    processes: Processes = None,
    json: Json = False,
) -> None:
    """Touch a simulated robot anywhere along its body.

    Robots with another stiffness than the model's and with tendon friction that it does not know, resting and moving,
    are pushed from a third of the length to the tip; the estimator finds the contact, its place and its force from the
    tip's pose, or with markers on the body. Counts false alarms of free motion as well. Exit status 1: a target is
    missed.

    In lockstep; takes several minutes.

    Example: tendond study contact --runs 100 --minutes 60
    """
    exit_on_signals(130)
    from tendond.cli.study.contact import run_contacts

    if not run_contacts(runs, minutes, seed, processes, out, as_json=json):
        raise typer.Exit(1)


study.command("sections")(sections)
