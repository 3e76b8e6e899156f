"""`tendond try`: options and help."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.options import Config, ConfigFile, Preset, Profile, chosen_file
from tendond.cli.signals import exit_on_signals


def try_rig(
    file: ConfigFile = None,
    config: Config = None,
    profile: Profile = None,
    preset: Preset = None,
    target: Annotated[
        str | None,
        typer.Option(
            "--target", metavar="X | X,Z | X,Y,Z", help="Target of the tip [m]. Default: the file's, or a moderate one."
        ),
    ] = None,
    time: Annotated[
        float | None, typer.Option("--time", min=0.1, help="Time of tracking [s]. Default: until the tip rests.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            help="Folder for log, report and configuration. Default: out/try-NAME, the next time out/try-NAME-2.",
        ),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace the trial in the folder.")] = False,
) -> None:
    """Try a configuration on the simulator.

    Starts simulator and controller, arms, moves the tip to a first target, stops, and writes a report. Takes the
    target from the file if it names one, else a moderate one within the robot's workspace. The real drivers are never
    started, whatever the file says. Each line of output stands behind its process; the last one says where the tip
    rests. Ctrl-C ends all processes.

    Exit status 1: the tip does not come to rest at the target.

    Examples: tendond try rig.toml; tendond try --preset nitinol --target 0.05
    """
    exit_on_signals(130)
    from tendond.cli.trying.run import run_try

    run_try(chosen_file(file, config), profile, preset, target=target, time=time, out=out, force=force)
