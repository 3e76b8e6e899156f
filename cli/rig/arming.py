"""`tendond arm --wait`: follow the arm from the request until it tracks."""

import time
from pathlib import Path

from rich.console import Console

from tendond.bus.client import open_client
from tendond.bus.operator import ask_status
from tendond.cli.common import load_config
from tendond.daemon.errors import DaemonError
from tendond.offline.processes import tip_in_words
from tendond.schemas.messages import Mode

POLL_SECONDS = 0.2
CONNECT_SECONDS = 1.0

ON_THE_WAY = (Mode.PROBE, Mode.PRETENSION)
"""Modes between the request and tracking; they end by themselves."""


def wait_for_tracking(config_file: Path | None) -> None:
    """Print each mode on the way to tracking; Ctrl-C leaves the arm as it is.

    Raises:
        TendondError: no controller, or the arm went into another mode: a fault, or somebody stopped it.
    """
    config = load_config(config_file)
    console = Console()
    with (
        open_client(config.bus.endpoint, CONNECT_SECONDS) as session,
        console.status("", refresh_per_second=5.0) as shown,
    ):
        printed: Mode | None = None
        began = time.monotonic()
        while (status := ask_status(session, config.rig.name)).mode in ON_THE_WAY:
            if status.mode is not printed:
                printed = status.mode
                console.print(f"{status.mode.value}: {status.reason}", highlight=False)
            shown.update(f"{status.mode.value} {time.monotonic() - began:.0f} s, {tip_in_words(status)}")
            time.sleep(POLL_SECONDS)
    if status.mode is not Mode.TRACKING:
        raise DaemonError(f"the arm does not track: {status.mode.value} ({status.reason})")
    print(f"tracking after {time.monotonic() - began:.0f} s; 'tendond stop' releases the tendons")
