"""Shared by several commands: configuration, signals, lines for people."""

import csv
import os
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import FrameType
from typing import TypeVar

from tendond.bus.systemd import Supervisor
from tendond.cli.include import parse_with_includes, read_text
from tendond.cli.signals import note
from tendond.schemas.config.presets import PROFILES
from tendond.schemas.config.rig import ConfigError, RigConfig, check_config, parse_config
from tendond.schemas.errors.explain import choose

Section = TypeVar("Section")
SYSTEM_LOGS = Path("/var/log/tendond")
"""Folder of the services' logs, which are bounded by default."""


def chosen_config(path: Path | None, profile: str | None) -> tuple[RigConfig, str]:
    """Load the configuration of a file or a profile, or the built-in one; return it with its name, for messages.

    Raises:
        ConfigError: see `load_config`; or both are given, or there is no such profile.
    """
    if profile is None:
        return load_config(path), str(path or "built-in configuration")
    if path is not None:
        raise ConfigError(f"--config {path} and --profile {profile}: give one of them")
    return parse_config(profile_text(profile), f"profile '{profile}'"), f"profile '{profile}'"


def profile_text(name: str) -> str:
    """Return the TOML of a profile.

    Raises:
        ConfigError: there is no such profile.
    """
    if name not in PROFILES:
        raise ConfigError(f"unknown profile '{name}': {choose(name, PROFILES)}")
    return PROFILES[name]


def load_config(path: Path | None) -> RigConfig:
    """Load the configuration of a file, or the built-in one.

    Raises:
        ConfigError: the file cannot be read, or is invalid.
    """
    if path is None:
        return RigConfig()
    config = parse_with_includes(read_text(path), path)
    if config.reference.file and not (config.reference.samples or config.reference.waypoints):
        reference = {
            **config.reference.model_dump(),
            **read_rows(path.parent / config.reference.file, config.reference.kind),
        }
        # the rest stays as it was read: which keys the file gave counts in messages
        config = config.model_copy(update={"reference": check_config({"reference": reference}, str(path)).reference})
    if "policy" in config.control.laws:
        from tendond.offline.learning.policy_file import with_policy  # NumPy, which few commands need

        config = with_policy(config, path.parent, str(path))
    return config


def read_rows(path: Path, kind: str) -> dict[str, list[tuple[float, ...]]]:
    """Read the file of a reference: CSV with a heading line and one row a line; return the key of [reference] it fills.

    Samples: time [s], x (or y) [m], z [m]; or x, y, z; or these and a direction, or a quaternion w, x, y, z. Waypoints
    of a path: without the time.

    Raises:
        ConfigError: the file cannot be read, or a line has another number of numbers.
    """
    widths, allowed = (
        ((3, 6, 7), "3 numbers, x, y, z [m]; 6 with a direction; or 7 with a quaternion w, x, y, z")
        if kind == "path"
        else (
            (3, 4, 7, 8),
            "three numbers: time [s], x (or y) [m], z [m]; or in space four, seven with a direction, or eight with a "
            "quaternion w, x, y, z",
        )
    )
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            lines = list(enumerate(csv.reader(stream), 1))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ConfigError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from error
    rows: list[tuple[float, ...]] = []
    for number, line in lines[1:]:
        try:
            row = tuple(float(cell) for cell in line)
        except ValueError:
            row = ()
        if len(row) not in widths:
            raise ConfigError(f"{path}:{number}: must be {allowed}")
        rows.append(row)
    return {"waypoints" if kind == "path" else "samples": rows}


def present(section: Section | None, name: str, path: Path | None) -> Section:
    """Return an optional section of a configuration that this command requires.

    Raises:
        ConfigError: it is missing.
    """
    if section is None:
        raise ConfigError(f"{path or 'built-in configuration'}: has no [{name}] section: add one, it may be empty")
    return section


def stop_on_signals() -> Callable[[], bool]:
    """Catch SIGINT and SIGTERM, for a loop that stops by itself; the returned function is true after the first signal.

    The exit status after SIGINT is still 130.
    """
    came: list[int] = []

    def catch(number: int, frame: FrameType | None) -> None:
        came.append(number)
        note(number)

    signal.signal(signal.SIGINT, catch)
    signal.signal(signal.SIGTERM, catch)
    return lambda: bool(came)


def log_folder() -> Path:
    """Return the folder of logs: the service's (systemd's LogsDirectory), or `log` in the current directory."""
    return Path(os.environ.get("LOGS_DIRECTORY", "log"))


def say_to(supervisor: Supervisor) -> Callable[[str], None]:
    """Return a `say` whose lines `systemctl status` shows as well."""

    def say_both(line: str) -> None:
        say(line)
        supervisor.status(line)

    return say_both


def say(line: str) -> None:
    """Print a line for people and the journal, at once; a closed stream is ignored."""
    with suppress(OSError):
        print(f"tendond: {line}", file=sys.stderr, flush=True)
