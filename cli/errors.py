"""Errors as lines on standard error, `tendond: what: remedy`, and the exit status of each."""

import errno
import os
import re
import sys
from contextlib import suppress
from itertools import takewhile
from typing import IO, Any

import typer

from tendond import TendondError
from tendond.cli.extras import missing_line
from tendond.cli.kernel_folder import NOWHERE

EXIT_FAILED = 1
EXIT_USAGE = 2

WRONG_USAGE: type[Any] = typer.BadParameter.__base__ or typer.BadParameter
"""Class of all errors of usage: click's, which newer versions of typer carry inside themselves."""

DISK_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS)
"""Errors of a disk that may come without the file's name: from a stream that was opened before."""

_UNIT = re.compile(r"\[([a-zA-Z/^0-9]+)\]")
_INVALID = re.compile(r"^Invalid value(?: for '?([^':]+)'?(?: \(env var: '\w+'\))?)?: ")


def say_error(line: str) -> None:
    """Print a line for people; a closed or full standard error is ignored."""
    with suppress(OSError):
        print(f"tendond: {line}", file=sys.stderr, flush=True)


def status_of(error: BaseException) -> int | None:
    """Print what went wrong and return the exit status; None for an error that is a defect, with its traceback.

    2: invalid usage or configuration; 1: anything else that failed or was refused.
    """
    if isinstance(error, WRONG_USAGE):
        return _usage(error)
    if isinstance(error, typer.Abort):
        say_error("no input: answer in a terminal, or give --yes where the command has it")
        return EXIT_FAILED
    if isinstance(error, ModuleNotFoundError) and (missing := missing_line(error.name or "")):
        say_error(missing)
        return EXIT_USAGE
    if isinstance(error, TendondError):
        for line in str(error).splitlines():
            say_error(line)
        return _of_ours(error)
    if isinstance(error, BrokenPipeError):  # as in `tendond config show | head`
        discard(sys.stdout)
        return EXIT_FAILED
    if isinstance(error, OSError) and error.filename is not None:
        say_error(f"{os.fsdecode(error.filename)}: {error.strerror}")
        return EXIT_FAILED
    if isinstance(error, OSError) and error.errno in DISK_ERRORS:
        say_error(f"the output cannot be written: {error.strerror}")
        discard(sys.stdout)
        return EXIT_FAILED
    if isinstance(error, RuntimeError) and "cannot cache function" in str(error):  # numba's, when a kernel is imported
        say_error(NOWHERE)
        return EXIT_FAILED
    return None


def discard(stream: IO[str]) -> None:
    """Send the rest of a stream nowhere, or the interpreter tries once more at its end."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _usage(error: typer.BadParameter) -> int:
    """Print an error of click as a line that names the command whose help to read."""
    if type(error).__name__ == "NoArgsIsHelpError":  # the message is the help
        print(error.format_message(), file=sys.stderr)
        return EXIT_USAGE
    text = in_our_words(error.format_message()) + _unit(error)
    if "see '" not in text:
        text += f"{' See' if text.endswith('?') else '; see'} '{_path(error)} --help'"
    say_error(text)
    return EXIT_USAGE


def _unit(error: typer.BadParameter) -> str:
    """Return the unit of an option whose value is out of range, from its help; empty for any other error."""
    found = _UNIT.search(getattr(getattr(error, "param", None), "help", None) or "")
    return f" {found[1]}" if found and " or equal to " in error.message else ""


def _path(error: typer.BadParameter) -> str:
    """Return the words of the command, from its context, or as they were typed."""
    if error.ctx is not None:
        return error.ctx.command_path
    return " ".join(["tendond", *takewhile(lambda word: not word.startswith("-"), sys.argv[1:])])


def in_our_words(message: str) -> str:
    """Turn click's message into one of ours: `--seed: -1 is not in the range x>=0`."""
    text = _INVALID.sub(lambda found: f"{found[1]}: " if found[1] else "", " ".join(message.split())).rstrip(".")
    text = text.replace(". Did you mean", ": did you mean").removeprefix("Got ").replace("Input should be", "must be")
    first = text.split(" ", 1)[0]
    return text if not first.istitle() else text[0].lower() + text[1:]


def _of_ours(error: TendondError) -> int:
    from tendond.daemon.errors import UsageError
    from tendond.schemas.config.rig import ConfigError

    return EXIT_USAGE if isinstance(error, (ConfigError, UsageError)) else EXIT_FAILED
