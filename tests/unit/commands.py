"""The command line in this process: what a command prints, says and returns."""

import sys
from dataclasses import dataclass
from unittest.mock import patch

import pytest

from tendond.daemon.cli.app import main


@dataclass(frozen=True)
class Ended:
    """How a command ended: exit status, standard output, standard error."""

    status: int
    out: str
    said: str


def tendond(capsys: pytest.CaptureFixture[str], *arguments: str) -> Ended:
    """Run a command; it sets no signal handlers that outlive it only where it says so in its own test."""
    capsys.readouterr()
    status = 0
    with patch.object(sys, "argv", ["tendond", *arguments]):
        try:
            main()
        except SystemExit as error:
            status = error.code if isinstance(error.code, int) else 0 if error.code is None else 1
    out, said = capsys.readouterr()
    return Ended(status, out, said)
