"""What several commands need: the configuration, the signals, and lines for people."""

import signal
import sys
from collections.abc import Callable
from pathlib import Path
from types import FrameType

from tendond.schemas.config import ConfigError, RigConfig, parse_config


def load_config(path: Path | None) -> RigConfig:
    """The configuration in a file, or the built-in one.

    Raises:
        ConfigError: the file cannot be read, or what is in it cannot be used.
    """
    if path is None:
        return RigConfig()
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: is no text in UTF-8") from error
    return parse_config(text, str(path))


def stop_on_signals() -> Callable[[], bool]:
    """Catch SIGINT and SIGTERM, for a loop that can end by itself; the function returned is true once one has come."""
    came: list[int] = []

    def note(number: int, frame: FrameType | None) -> None:
        came.append(number)

    signal.signal(signal.SIGINT, note)
    signal.signal(signal.SIGTERM, note)
    return lambda: bool(came)


def say(line: str) -> None:
    """A line for people and the journal, at once."""
    print(f"tendond: {line}", file=sys.stderr, flush=True)
