"""Options that several commands share."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.completion import configurations, distributions, plants, presets, profiles
from tendond.drivers.ros2.distributions import DISTRIBUTIONS


def chosen_file(file: Path | None, option: Path | None) -> Path | None:
    """Return the configuration given as argument or as option.

    Raises:
        BadParameter: it is given twice.
    """
    if file is not None and option is not None:
        raise typer.BadParameter("give the file once", param_hint="--config")
    return file or option


def known_distribution(name: str) -> str:
    """Return the name of a distribution of ROS 2.

    Raises:
        BadParameter: it is none of those that are supported.
    """
    if name not in DISTRIBUTIONS:
        raise typer.BadParameter(f"'{name}': choose one of {', '.join(DISTRIBUTIONS)}", param_hint="--distro")
    return name


Config = Annotated[
    Path | None,
    typer.Option(
        "--config", "-c", help="Rig configuration, TOML. Default: the paper's robot.", autocompletion=configurations
    ),
]
ConfigFile = Annotated[
    Path | None,
    typer.Argument(
        metavar="FILE",
        help="Rig configuration, TOML; same as --config.",
        show_default=False,
        autocompletion=configurations,
    ),
]
Preset = Annotated[
    str | None,
    typer.Option("--preset", help="Instead of --config: a robot by name, see config presets.", autocompletion=presets),
]
Profile = Annotated[
    str | None,
    typer.Option(
        "--profile", help="Instead of --config: paper, rig or nasty, see docs/simulator.md.", autocompletion=profiles
    ),
]
Lockstep = Annotated[
    bool, typer.Option("--lockstep", help="One cycle per pose, without a clock; for both run and simulate.")
]
PlantName = Annotated[
    str | None,
    typer.Option(
        "--plant",
        help="shooting, general or mujoco, instead of simulator.solver; mujoco needs the extra of that name.",
        autocompletion=plants,
    ),
]
Cycles = Annotated[int | None, typer.Option("--cycles", min=1, help="Number of cycles to run.")]
Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]
Jobs = Annotated[
    int | None, typer.Option("--jobs", "-j", min=1, max=1024, help="Parallel processes. Default: one per processor.")
]
Processes = Annotated[
    int | None, typer.Option("--processes", min=1, help="Parallel processes. Default: one per processor.")
]
Yes = Annotated[bool, typer.Option("--yes", help="Do not ask for confirmation.")]
Distro = Annotated[
    str,
    typer.Option("--distro", help=f"ROS 2 distribution: {', '.join(DISTRIBUTIONS)}.", autocompletion=distributions),
]
