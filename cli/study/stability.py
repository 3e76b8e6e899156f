"""`tendond study stability`: eigenvalues of the real loop as a map over robots, rates, delays, damping, E and bend."""

import json as encoder
from dataclasses import asdict
from math import inf
from pathlib import Path
from typing import Annotated, Any

import typer

from tendond.cli.completion import laws, presets
from tendond.cli.options import Json
from tendond.cli.signals import exit_on_signals


def stability(
    robot: Annotated[
        list[str] | None,
        typer.Option("--robot", help="Preset; may be repeated. Default: all.", autocompletion=presets),
    ] = None,
    law: Annotated[
        str | None,
        typer.Option("--law", help="Law; default: the one that each robot has by default.", autocompletion=laws),
    ] = None,
    short: Annotated[bool, typer.Option("--short", help="Only 100 Hz and a bend of 60 degrees.")] = False,
    track: Annotated[
        bool, typer.Option("--track", help="Run each robot to a target at 50, 100, 250, 500 Hz instead.")
    ] = False,
    config: Annotated[
        Path | None, typer.Option("--config", "-c", help="A rig's own loop, and how far it is from its edge.")
    ] = None,
    bend: Annotated[
        float, typer.Option("--bend", min=1.0, max=170.0, help="Bend of the model at the target, with --config [deg].")
    ] = 60.0,
    json: Json = False,
) -> None:
    """Compute the eigenvalues of the discrete loop.

    Of the real cycle with its plant, both general rods, differenced about resting targets: each robot at 50 to 500 Hz
    and three bends, then with delays, less damping and another E. Minutes for each robot. With --track no eigenvalues:
    each robot runs for 6 s to a target at which its agonist bends it by 60 degrees, and is to rest there. With --config
    the loop of that rig, with its law, and with later poses, another E, less damping and other gains, each until it is
    unstable. Exit status 1: a loop is unstable, with --config that of the rig as it is; or a robot does not rest at
    its target.

    Example: tendond study stability --robot nitinol --short
    """
    exit_on_signals(130)
    if config is not None:
        if robot or short or track:
            raise typer.BadParameter("names a robot: not with --robot, --short or --track", param_hint="--config")
        if not run_margins(config, law, bend, as_json=json):
            raise typer.Exit(1)
        return
    from tendond.daemon.control.laws import LAWS, StatefulLaw
    from tendond.schemas.config.rod.presets import PRESETS
    from tendond.schemas.errors.explain import choose

    for name in robot or ():
        if name not in PRESETS:
            raise typer.BadParameter(f"'{name}': {choose(name, PRESETS)}", param_hint="--robot")
    able = [name for name, one in LAWS.items() if track or not isinstance(one, StatefulLaw)]
    if law is not None and law not in able:
        raise typer.BadParameter(f"'{law}': {choose(law, able)}", param_hint="--law")
    robots = tuple(robot or PRESETS)
    if track:
        good = run_track(robots, law, short=short, as_json=json)
    else:
        good = run_stability(robots, law, short=short, as_json=json)
    if not good:
        raise typer.Exit(1)


def run_margins(path: Path, law: str | None, bend: float, *, as_json: bool) -> bool:
    """Print the margins of a rig's loop; return whether it is stable as configured.

    Args:
        path: of its configuration. law: in the place of its own. bend: at the target [degrees]. as_json: print JSON.
    """
    from tendond.cli.common import load_config, say
    from tendond.model.numerics.announce import announce_compilation
    from tendond.offline.stability.margins import margins, summary
    from tendond.schemas.config.rig import check_config

    announce_compilation(say)
    config = load_config(path)
    if law is not None:
        values = config.model_dump(mode="json")
        values["control"]["law"] = law
        config = check_config(values, str(path))
    found = []
    if not as_json:
        print(f"{config.control.law} at {1.0 / config.loop.period:g} Hz, bent by {bend:g} degrees\n")
        print("| | value | radius | decay 1/s | frequency Hz | |\n| --- | --- | --- | --- | --- | --- |", flush=True)
    for one in margins(config, path.stem, bend):
        found.append(one)
        if not as_json:
            end = one.result
            print(
                f"| {one.name} | {one.value:g} | {end.radius:.5f} | {end.decay:.3g} | {end.frequency:.3g} "
                f"| {'' if end.stable else 'UNSTABLE'} |",
                flush=True,
            )
    if as_json:
        rows = [
            {"name": one.name, "value": one.value, "stable": one.result.stable, **asdict(one.result)} for one in found
        ]
        print(encoder.dumps(rows, indent=2))
    else:
        print("\n" + "\n".join(summary(found)))
    return found[0].result.stable


HEAD = (
    "| robot | law | rate Hz | delay | damping | E | bend deg | tension N | radius | decay 1/s | frequency Hz | |\n"
    "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"
)


def run_stability(robots: tuple[str, ...], law: str | None, *, short: bool, as_json: bool) -> bool:
    """Print the map; return whether every loop is stable.

    Args:
        robots: presets. law: name; none: each robot's default. short: one case each. as_json: print JSON, not a table.
    """
    from tendond.cli.common import say
    from tendond.model.numerics.announce import announce_compilation
    from tendond.offline.progress import tracked
    from tendond.offline.stability.cases import map_cases, solve

    announce_compilation(say)
    found = []
    if not as_json:
        print(HEAD, flush=True)
    cases = list(map_cases(robots, law, short=short))
    for case in tracked(cases, len(cases), "loops", quiet=as_json):
        one = solve(case)
        found.append(one)
        if not as_json:
            print(
                f"| {case.robot} | {one.law} | {case.rate:g} | {case.delay} | {case.damping:g} | {case.stiffness:g} "
                f"| {case.bend:g} | {one.tension:.3g} | {one.radius:.5f} | {one.decay:.3g} | {one.frequency:.3g} "
                f"| {'' if one.stable else 'UNSTABLE'} |",
                flush=True,
            )
    if as_json:
        print(encoder.dumps([{**asdict(one), "stable": one.stable} for one in found], indent=2))
    else:
        print(f"\n{sum(one.stable for one in found)} of {len(found)} loops are stable")
    return all(one.stable for one in found)


def _data(one: Any) -> dict[str, object]:
    """Return a run for JSON, which has no infinity: null where the run did not begin."""
    finite = {key: None if value == inf else value for key, value in asdict(one).items()}
    return {**finite, "settled": one.settled}


TRACK_HEAD = (
    "| robot | law | rate Hz | mode | from target, of length | ripple, of length | |\n"
    "| --- | --- | --- | --- | --- | --- | --- |"
)


def run_track(robots: tuple[str, ...], law: str | None, *, short: bool, as_json: bool) -> bool:
    """Print what runs to a target come to; return whether every robot rests there.

    Args:
        robots: presets. law: name; none: each robot's default. short: 100 Hz only. as_json: print JSON, not a table.
    """
    from tendond.cli.common import say
    from tendond.model.numerics.announce import announce_compilation
    from tendond.offline.progress import tracked
    from tendond.offline.stability.cases import RATES
    from tendond.offline.stability.track import track

    announce_compilation(say)
    if not as_json:
        print(TRACK_HEAD, flush=True)
    found = []
    some = [(name, rate) for name in robots for rate in (RATES[1:2] if short else RATES)]
    for name, rate in tracked(some, len(some), "runs", quiet=as_json):
        one = track(name, law, rate)
        found.append(one)
        if not as_json:
            print(
                f"| {one.robot} | {one.law} | {one.rate:g} | {one.mode} | {1e2 * one.missing:.3f} % "
                f"| {1e2 * one.ripple:.3f} % | {'' if one.settled else f'DOES NOT REST: {one.why}'} |",
                flush=True,
            )
    if as_json:
        print(encoder.dumps([_data(one) for one in found], indent=2))
    else:
        print(f"\n{sum(one.settled for one in found)} of {len(found)} runs rest at their target")
    return all(one.settled for one in found)
