"""The command line in this process: what a command prints, says and returns."""

import signal
import sys
from dataclasses import dataclass
from unittest.mock import patch

import pytest

from tendond.cli.app import main


@dataclass(frozen=True)
class Ended:
    """How a command ended: exit status, standard output, standard error."""

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
    return Ended(status, out, said)
