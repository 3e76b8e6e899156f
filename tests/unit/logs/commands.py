"""The command line in this process, and logs for it."""

import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from unittest import mock

from tendond.cli.app import main


@dataclass(frozen=True)
class Said:
    """Output and exit status of a command."""

    returncode: int
    stdout: str
    stderr: str


def run_command(*arguments: str) -> Said:
    """The program, from its entry point, in this process."""
    out, err, code = StringIO(), StringIO(), 0
    with redirect_stdout(out), redirect_stderr(err), mock.patch.object(sys, "argv", ["tendond", *arguments]):
        try:
            main()
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 0
    return Said(code, out.getvalue(), err.getvalue())


def damaged(path: Path, out: Path) -> Path:
    """A copy with a flipped bit in its largest chunk that is not the first."""
    data = bytearray(path.read_bytes())
    data[len(data) * 2 // 3] ^= 0x10
    out.write_bytes(data)
    return out
