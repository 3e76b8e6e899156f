"""`tendond demo`: options and help."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.completion import plants, profiles, scenarios
from tendond.cli.signals import exit_on_signals


def demo(
    scenario: Annotated[
        str,
        typer.Option("--scenario", help="plane, wired or spatial, see above.", autocompletion=scenarios),
    ] = "plane",
    out: Annotated[
        Path | None,
        typer.Option("--out", help="Folder for log, figures and summary. Default: out/demo, or out/demo-SCENARIO."),
    ] = None,
    profile: Annotated[
        str | None,
        typer.Option(
            "--profile",
            help="For scenario plane: paper (default), rig or nasty, see docs/simulator.md.",
            autocompletion=profiles,
        ),
    ] = None,
    lockstep: Annotated[
        bool, typer.Option("--lockstep", help="For scenario plane: no clock, so that a busy computer loses no pose.")
    ] = False,
    plant: Annotated[
        str | None,
        typer.Option(
            "--plant", help="For scenario plane: shooting, general or mujoco (an extra).", autocompletion=plants
        ),
    ] = None,
) -> None:
    """Run the controller on a simulated robot, with log and figures.

    Real processes on Zenoh, in real time.

    plane: the paper's experiment, in ten seconds. wired: the same robot behind the real drivers, with emulated servos
    on a serial port and Tracker packets on UDP, in half a minute. spatial: the tip on a circle in space with all
    tendons, with ideal tensions and behind the real drivers, in a minute.

    --plant mujoco, for plane, simulates the robot in MuJoCo, of which the controller's rod model shares no line.

    Examples: tendond demo --profile rig --out out/demo-rig; tendond demo --scenario wired; tendond demo --plant mujoco
    """
    from tendond.schemas.errors.explain import choose

    exit_on_signals(130)
    from tendond.cli.common import profile_text
    from tendond.cli.completion import PLANTS
    from tendond.cli.warm.progress import compile_with_progress
    from tendond.offline.demo.scenarios import SCENARIOS, run_plane
    from tendond.offline.kernels import SHOOTING

    if scenario not in SCENARIOS:
        raise typer.BadParameter(f"'{scenario}': {choose(scenario, SCENARIOS)}", param_hint="--scenario")
    folder = out or Path("out/demo" if scenario == "plane" else f"out/demo-{scenario}")
    if profile is not None and scenario != "plane":
        raise typer.BadParameter(f"the scenario '{scenario}' has a profile of its own", param_hint="--profile")
    if lockstep and scenario != "plane":
        raise typer.BadParameter(f"the scenario '{scenario}' runs in real time", param_hint="--lockstep")
    if plant is not None and scenario != "plane":
        raise typer.BadParameter(f"the scenario '{scenario}' has a plant of its own", param_hint="--plant")
    if plant is not None and plant not in PLANTS:
        raise typer.BadParameter(f"'{plant}': {choose(plant, PLANTS)}", param_hint="--plant")
    if profile is not None:
        profile_text(profile)
    compile_with_progress([[SHOOTING]])
    if profile is not None or lockstep or plant is not None:
        run_plane(folder, profile or "paper", lockstep=lockstep, plant=plant)
    else:
        SCENARIOS[scenario](folder)
