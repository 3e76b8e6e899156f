"""`tendond arm --wait` and `stop --wait`: follow the arm from the request until it tracks, or is idle."""

import time
from collections.abc import Callable
from pathlib import Path

from rich.console import Console

from tendond.bus.client import open_client
from tendond.bus.operator import ask_status
from tendond.cli.common import load_config, say
from tendond.cli.rig.operator import option_of, remedy
from tendond.daemon.errors import DaemonError
from tendond.offline.processes import tip_in_words
from tendond.schemas.messages import Mode, Status

POLL_SECONDS = 0.2
CONNECT_SECONDS = 1.0

ARMING = (Mode.PROBE, Mode.PRETENSION)
RELEASING = (Mode.RELEASING,)
"""Modes between a request and its end; they end by themselves."""


def wait_for_tracking(config_file: Path | None) -> None:
    """Print each mode on the way to tracking; Ctrl-C leaves the arm as it is, and says so.

    Raises:
        TendondError: no controller, or the arm went into another mode: a fault, or somebody stopped it.
    """
    option = option_of(config_file)
    status, seconds = _follow(
        config_file,
        ARMING,
        lambda mode: (
            f"no longer waiting: the controller goes on by itself ({mode}, then tracking); "
            f"'tendond stop{option}' releases the tendons"
        ),
    )
    if status.mode is not Mode.TRACKING:
        raise DaemonError(f"the arm does not track: {_ended(status, config_file)}")
    print(f"tracking after {seconds:.0f} s; 'tendond stop{option}' releases the tendons")


def wait_for_idle(config_file: Path | None) -> None:
    """Wait until the tendons are released.

    Raises:
        TendondError: no controller, or the arm is in another mode: a fault, or somebody armed it.
    """
    status, seconds = _follow(
        config_file, RELEASING, lambda mode: "no longer waiting: the controller goes on releasing the tendons"
    )
    if status.mode is not Mode.IDLE:
        raise DaemonError(f"the arm is not idle: {_ended(status, config_file)}")
    print(f"idle after {seconds:.0f} s: the tendons are released")


def _ended(status: Status, config_file: Path | None) -> str:
    to_clear = remedy(status, load_config(config_file), config_file)
    return f"{status.mode.value} ({status.reason}){f': {to_clear}' if to_clear else ''}"


def _follow(
    config_file: Path | None, modes: tuple[Mode, ...], interrupted: Callable[[str], str]
) -> tuple[Status, float]:
    """Print each of these modes until another one comes; return that status, and the time it took [s].

    Args:
        config_file: of the rig.
        modes: that end by themselves.
        interrupted: returns what to say on Ctrl-C, from the last mode.
    """
    config = load_config(config_file)
    console = Console()
    printed: Mode | None = None
    began = time.monotonic()
    try:
        with (
            open_client(config.bus.endpoint, CONNECT_SECONDS) as session,
            console.status("", refresh_per_second=5.0) as shown,
        ):
            while (status := ask_status(session, config.rig.name)).mode in modes:
                if status.mode is not printed:
                    printed = status.mode
                    console.print(f"{status.mode.value}: {status.reason}", highlight=False)
                shown.update(f"{status.mode.value} {time.monotonic() - began:.0f} s, {tip_in_words(status)}")
                time.sleep(POLL_SECONDS)
    except (SystemExit, KeyboardInterrupt):  # as the signal's handler raises it
        say(interrupted((printed or modes[0]).value))
        raise
    return status, time.monotonic() - began
