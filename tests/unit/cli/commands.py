"""The command line in this process: output, messages and exit status of a command."""

import signal
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any
from unittest.mock import patch

import pytest
from typer.core import TyperGroup
from typer.main import get_command

from tendond.cli.app import app, main


def subcommands(command: object) -> dict[str, Any]:
    """Commands of a group, by name."""
    assert isinstance(command, TyperGroup)
    return dict(command.commands)


ANNOUNCEMENT = "tendond: compiling the rod's kernels"
"""Beginning of the line on standard error of the first command after a change of the kernels."""


@dataclass(frozen=True)
class Ended:
    """Result of a command: exit status, standard output, standard error but for `ANNOUNCEMENT`."""

    status: int
    out: str
    said: str


def tendond(capsys: pytest.CaptureFixture[str], *arguments: str) -> Ended:
    """Run a command to its end; the signal handlers that it sets do not outlive it."""
    capsys.readouterr()
    status = 0
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    with patch.object(sys, "argv", ["tendond", *arguments]):
        try:
            main()
        except SystemExit as error:
            status = error.code if isinstance(error.code, int) else 0 if error.code is None else 1
        finally:
            for number, handler in handlers.items():
                signal.signal(number, handler)
    out, said = capsys.readouterr()
    assert "\x1b" not in out + said, "colours, and no terminal"
    lines = said.splitlines(keepends=True)
    return Ended(status, out, "".join(line for line in lines if not line.startswith(ANNOUNCEMENT)))


def walk(command: Any, name: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield every command and group, by its words."""
    if name:
        yield name, command
    for word, inner in getattr(command, "commands", {}).items():
        yield from walk(inner, (*name, word))


TENDOND = [sys.executable, "-m", "tendond.cli"]
_NAMES = {
    id(one): (name, one)
    for name, one in sorted(walk(get_command(app)), key=lambda found: -len(found[0]))
    if not one.hidden
}
COMMANDS = dict(sorted(_NAMES.values(), key=lambda found: found[0]))
"""Every command and group once, by its shortest spelling: the everyday commands are in their groups as well."""

RUNNABLE = {
    name: one for name, one in COMMANDS.items() if not getattr(one, "commands", {}) or one.invoke_without_command
}


def few_lines(said: str) -> bool:
    """Check that a message for people is one to six lines, without a traceback."""
    lines = said.strip().splitlines()
    return 1 <= len(lines) <= 6 and "Traceback" not in said
