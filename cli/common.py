"""Shared by several commands: configuration, signals, lines for people."""

import csv
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

Section = TypeVar("Section")


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
        raise ConfigError(f"unknown profile '{name}': choose one of {', '.join(PROFILES)}")
    return PROFILES[name]


def load_config(path: Path | None) -> RigConfig:
    """Load the configuration of a file, or the built-in one.

    Raises:
        ConfigError: the file cannot be read, or is invalid.
    """
    if path is None:
        return RigConfig()
    config = parse_with_includes(read_text(path), path)
    if config.reference.file and not config.reference.samples:
        samples = read_samples(path.parent / config.reference.file)
        reference = {**config.reference.model_dump(), "samples": samples}
        config = check_config({**config.model_dump(), "reference": reference}, str(path))
    return config


def load_runnable(path: Path | None) -> RigConfig:
    """Load a configuration whose robot the controller can run.

    Raises:
        ConfigError: see `load_config`; or it cannot.
    """
    config = load_config(path)
    if config.rod.refusal:
        raise ConfigError(f"{path}: {config.rod.refusal}")
    return config


def read_samples(path: Path) -> list[tuple[float, ...]]:
    """Read the samples of a reference: a CSV file with a heading, then time [s], x (or y) [m], z [m], or x, y, z.

    Raises:
        ConfigError: the file cannot be read, or a line is not three or four numbers.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            lines = list(enumerate(csv.reader(stream), 1))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ConfigError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from error
    samples: list[tuple[float, ...]] = []
    for number, line in lines[1:]:
        try:
            sample = tuple(float(cell) for cell in line)
        except ValueError:
            sample = ()
        if len(sample) not in (3, 4):
            raise ConfigError(
                f"{path}:{number}: must be three numbers: time [s], x (or y) [m], z [m]; or in space four"
            )
        samples.append(sample)
    return samples


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
