"""`tendond study control`: the laws beside each other."""

import json
from typing import Annotated

import typer

from tendond.cli.completion import laws, presets
from tendond.cli.options import Json
from tendond.cli.signals import exit_on_signals


def control(
    law: Annotated[
        list[str] | None, typer.Option("--law", help="Control law; may be repeated.", autocompletion=laws)
    ] = None,
    task: Annotated[list[str] | None, typer.Option("--task", help="Task; may be repeated.")] = None,
    plant: Annotated[
        list[str] | None, typer.Option("--plant", help="matched, unlike, friction or wired; may be repeated.")
    ] = None,
    robot: Annotated[
        list[str] | None,
        typer.Option(
            "--robot",
            help="Preset of [rod], or all: of one, two and three sections; may be repeated. Default: paper.",
            autocompletion=presets,
        ),
    ] = None,
    observer: Annotated[str, typer.Option("--observer", help="Kind of observer: force or kalman.")] = "force",
    rate: Annotated[int, typer.Option("--rate", min=10, max=1000, help="Rate of the loop [Hz].")] = 100,
    seconds: Annotated[
        float | None, typer.Option("--seconds", min=0.2, max=600.0, help="Time that is tracked. Default: all of it.")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the noise.")] = 0,
    json_: Json = False,
) -> None:
    """Compare the laws on the same tasks.

    Circles, a figure-eight, a helix, a step and the paper's task, with --robot all also paths of robots of two and
    three sections; on a plant that is the model, one unlike it, one with tendon friction, and behind emulated servos;
    with the same seed and estimator: error of the true tip, settling, ripple, limits that were met, and processor time
    of a cycle. Exit status 1: a goal is missed.

    Example: tendond study control --law mpc --law sensitivity --task "circle 250 mm"
    """
    exit_on_signals(130)
    from tendond.daemon.control.laws import LAWS
    from tendond.offline.control.cases import PLANTS, ROBOTS, TASKS, Case
    from tendond.offline.control.report import HEADING, misses, row
    from tendond.offline.control.run import run
    from tendond.offline.progress import tracked

    robots = [one for name in robot or ["paper"] for one in (ROBOTS if name == "all" else [name])]
    for asked, known, hint in ((law, LAWS, "--law"), (task, TASKS, "--task"), (plant, PLANTS, "--plant")):
        for name in asked or ():
            if name not in known:
                from tendond.schemas.errors.explain import choose

                raise typer.BadParameter(f"'{name}': {choose(name, known)}", param_hint=hint)
    cases = [
        Case(a, b, c, observer, d, 1.0 / rate, seed)
        for d in robots
        for b in task or TASKS
        for c in plant or PLANTS
        for a in law or LAWS
    ]
    done = []
    if not json_:
        print(HEADING)
    cases = [case for case in cases if case.possible]
    for case in tracked(cases, len(cases), "runs", quiet=json_):
        done.append((case, run(case, seconds)))
        if not json_:
            print(row(*done[-1]), flush=True)
    missed = misses(done)
    if json_:
        print(json.dumps({"rows": [vars(a) | vars(b) for a, b in done], "missed": missed}, indent=2))
    for one in [] if json_ else missed:
        print(f"missed: {one}")
    if missed:
        raise typer.Exit(1)
