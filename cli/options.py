"""Options that several commands share."""

from pathlib import Path
from typing import Annotated

import typer


def _profiles() -> list[str]:
    from tendond.schemas.config.presets import PROFILES

    return list(PROFILES)


def laws() -> list[str]:
    """The laws' names, for the shell's completion."""
    from tendond.daemon.control.laws import LAWS

    return list(LAWS)


def faults() -> list[str]:
    """The simulator's faults, for the shell's completion."""
    from tendond.schemas.faults import Fault

    return list(Fault)


Config = Annotated[
    Path | None, typer.Option("--config", "-c", help="Rig configuration, TOML. Left out: the paper's robot.")
]
Profile = Annotated[
    str | None,
    typer.Option(
        "--profile", help="Instead of --config: paper, rig or nasty, see docs/simulator.md.", autocompletion=_profiles
    ),
]
Lockstep = Annotated[
    bool, typer.Option("--lockstep", help="One cycle per pose instead of the clock; give it to run and simulate both.")
]
Cycles = Annotated[int | None, typer.Option("--cycles", min=1, help="End after so many cycles.")]
Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]
Yes = Annotated[bool, typer.Option("--yes", help="Do not ask.")]
