"""`tendond study sections`: the table of robots of sections on paths of poses."""

import json
from dataclasses import asdict
from typing import Annotated

import typer

from tendond.cli.options import Json
from tendond.cli.signals import exit_on_signals


def sections(
    duration: Annotated[float, typer.Option("--duration", min=2.0, max=60.0, help="Duration of a path [s].")] = 6.0,
    quick: Annotated[bool, typer.Option("--quick", help="One path of two sections, on the model itself.")] = False,
    as_json: Json = False,
) -> None:
    """Follow paths of poses with robots of two and three sections.

    In lockstep, on the model itself and on a plant unlike it: 2 cycles of delay, 0.1 mm of noise, E -10 %, a body on
    the tip that weighs on the robot as 20 g do on the paper's. Exit status 1: a fault, or on the model itself a root
    mean square above 3 mm or 2 degrees.

    Example: tendond study sections --quick
    """
    exit_on_signals(130)
    if not run_sections_study(duration, quick=quick, as_json=as_json):
        raise typer.Exit(1)


def run_sections_study(duration: float, *, quick: bool, as_json: bool) -> bool:
    """Run the trials and print the table; return whether all meet the goals.

    Raises:
        TendondError: a plant has no solution.
    """
    from tendond.cli.common import say
    from tendond.model.numerics.announce import announce_compilation
    from tendond.offline.progress import tracked
    from tendond.offline.trials.paths import MATCHED, UNLIKE
    from tendond.offline.trials.sections import run_section_trial, section_trials

    announce_compilation(say)
    trials = list(section_trials(duration, quick=quick))
    rows = [(one, run_section_trial(one)) for one in tracked(trials, len(trials), "paths", quiet=as_json)]
    if as_json:
        names = ("robot", "name", "unlike")
        print(
            json.dumps([{name: getattr(one, name) for name in names} | asdict(found) for one, found in rows], indent=2)
        )
        return all(found.meets(one) for one, found in rows)
    print("| robot | trajectory | plant | RMS | worst | after it | smallest tension | ends in |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for one, found in rows:
        ends = found.mode if found.mode == "tracking" else f"{found.mode}: {found.reason}"
        print(
            f"| {one.robot} | {one.name} | {UNLIKE if one.unlike else MATCHED} | "
            f"{found.rms_mm:.2f} mm, {found.rms_degrees:.2f} deg | "
            f"{found.worst_mm:.2f} mm, {found.worst_degrees:.2f} deg | "
            f"{found.end_mm:.2f} mm, {found.end_degrees:.2f} deg | {found.min_tension:.2f} N | {ends} |"
        )
    return all(found.meets(one) for one, found in rows)
