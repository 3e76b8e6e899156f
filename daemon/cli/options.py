"""Options that several commands share."""

from pathlib import Path
from typing import Annotated

import typer

Config = Annotated[
    Path | None, typer.Option("--config", "-c", help="Rig configuration, TOML. Left out: the paper's robot.")
]
Profile = Annotated[
    str | None, typer.Option("--profile", help="Instead of --config: paper, rig or nasty, see docs/simulator.md.")
]
Lockstep = Annotated[
    bool, typer.Option("--lockstep", help="One cycle per pose instead of the clock; give it to run and simulate both.")
]
Cycles = Annotated[int | None, typer.Option("--cycles", min=1, help="End after so many cycles.")]
Yes = Annotated[bool, typer.Option("--yes", help="Do not ask.")]
