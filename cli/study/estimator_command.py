"""`tendond study estimator`: options and help."""

from typing import Annotated

import typer

from tendond.cli.options import Json, Processes
from tendond.cli.signals import exit_on_signals


def estimator(
    robot: Annotated[str, typer.Option("--robot", help="Preset, or file of a configuration.")] = "paper",
    runs: Annotated[int, typer.Option("--runs", min=1, max=100000, help="Runs of each case.")] = 200,
    first: Annotated[int, typer.Option("--first", min=0, help="Seed of the first run.")] = 0,
    loop: Annotated[
        bool, typer.Option("--loop", help="Compare loops instead: each law with the filter, and with fixed gains.")
    ] = False,
    matched: Annotated[
        bool, typer.Option("--matched", help="Robots like the model: what camera and filter leave by themselves.")
    ] = False,
    tension_error: Annotated[
        float, typer.Option("--tension-error", min=1e-3, max=1.0, help="The filter's observer.tension_error.")
    ] = 0.07,
    tension_error_time: Annotated[
        float, typer.Option("--tension-error-time", min=0.1, max=3600.0, help="Its observer.tension_error_time [s].")
    ] = 3.0,
    processes: Processes = None,
    json: Json = False,
) -> None:
    """Hold the estimator to the truth on robots unlike its model.

    Seeded runs of random motion: E wrong by up to 10 %, friction of the tendons wrong, a camera's noise; free, with a
    sudden load on the tip, by markers alone, and with markers lost or exchanged. Error of tip, shape and load, beside
    observers of fixed gains on the same measurements; whether the ellipsoids hold what they say; time of a cycle.
    200 runs take about a quarter of an hour on two processors. Exit status 1: a goal is missed.

    --loop runs backstepping, sliding mode and sensitivity in closed loop, in lockstep, on plants unlike the model, with
    the filter and with fixed gains: error of the true tip in motion and at rest. About a quarter of an hour.

    Example: tendond study estimator --runs 20
    """
    exit_on_signals(130)
    from tendond.cli.study.commands import processor_count

    if loop:
        from tendond.cli.study.estimator import run_loop_study

        if not run_loop_study(processes or processor_count(), as_json=json):
            raise typer.Exit(1)
        return
    from tendond.cli.study.estimator import run_estimator_study

    noise = tension_error, tension_error_time
    if not run_estimator_study(
        robot, runs, first, processes or processor_count(), noise, matched=matched, as_json=json
    ):
        raise typer.Exit(1)
