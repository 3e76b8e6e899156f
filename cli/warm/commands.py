"""`tendond warm`: options and help."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.signals import exit_on_signals


def warm(
    config_file: Annotated[
        Path | None,
        typer.Option("-c", "--config", help="Compile what this one needs. Default: all, for up to 4 tendons."),
    ] = None,
) -> None:
    """Compile the model's kernels, so that no later start has to.

    Takes a minute or two, once for each user and version; a second when they are compiled. The shooting rod has
    kernels for up to four, eight and sixteen tendons, the general rod the same for all. Ctrl-C ends it at once; what
    is compiled by then is kept.

    Example: tendond warm -c rig.toml
    """
    exit_on_signals(130)
    from tendond.cli.common import load_config
    from tendond.cli.warm.progress import compile_with_progress
    from tendond.offline.kernels import ALL, parts_of

    if config_file is None:
        compile_with_progress(ALL)
        return
    config = load_config(config_file)
    compile_with_progress(parts_of(config), len(config.rod.tendon_positions))
