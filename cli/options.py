"""Options that several commands share."""

from pathlib import Path
from typing import Annotated

import typer


def _profiles() -> list[str]:
    from tendond.schemas.config.presets import PROFILES

    return list(PROFILES)


def presets() -> list[str]:
    """Return the names of the robots, for the shell's completion."""
    from tendond.schemas.config.rod.presets import PRESETS

    return list(PRESETS)


def chosen_file(file: Path | None, option: Path | None) -> Path | None:
    """Return the configuration given as argument or as option.

    Raises:
        BadParameter: it is given twice.
    """
    if file is not None and option is not None:
        raise typer.BadParameter("give the file once", param_hint="--config")
    return file or option


def laws() -> list[str]:
    """Return the names of the control laws, for the shell's completion."""
    from tendond.daemon.control.laws import LAWS

    return list(LAWS)


def faults() -> list[str]:
    """Return the names of the simulator's faults, for the shell's completion."""
    from tendond.schemas.faults import Fault

    return list(Fault)


def scenarios() -> list[str]:
    """Return the names of the demo's scenarios, for the shell's completion."""
    from tendond.offline.demo.scenarios import SCENARIOS

    return list(SCENARIOS)


Config = Annotated[
    Path | None, typer.Option("--config", "-c", help="Rig configuration, TOML. Default: the paper's robot.")
]
ConfigFile = Annotated[
    Path | None, typer.Argument(metavar="FILE", help="Rig configuration, TOML; same as --config.", show_default=False)
]
Preset = Annotated[
    str | None,
    typer.Option("--preset", help="Instead of --config: a robot by name, see config presets.", autocompletion=presets),
]
Profile = Annotated[
    str | None,
    typer.Option(
        "--profile", help="Instead of --config: paper, rig or nasty, see docs/simulator.md.", autocompletion=_profiles
    ),
]
Lockstep = Annotated[
    bool, typer.Option("--lockstep", help="One cycle per pose, without a clock; for both run and simulate.")
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
