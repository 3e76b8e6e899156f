"""Child processes: `tendond` commands that are started and ended, and their progress."""

import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterable
from contextlib import suppress

from rich.progress import BarColumn, ProgressColumn, TextColumn, TimeElapsedColumn

from tendond.schemas.messages import Status

START_SECONDS = 120.0
"""Timeout for a process to start; it may have to compile its kernels."""

END_SECONDS = 10.0
POLL_SECONDS = 0.1
JOIN_SECONDS = 2.0
"""Timeout for the last lines of a process that has ended: a child of its own may keep the pipe open."""


def start(*arguments: str, own_session: bool = False, piped: bool = False) -> "subprocess.Popen[bytes]":
    """Start `tendond` with these arguments.

    Args:
        arguments: of the command line.
        own_session: the terminal's Ctrl-C does not reach it.
        piped: its output goes into a pipe, for `Output`, instead of where this process' goes.
    """
    pipe = subprocess.PIPE if piped else None
    command = [sys.executable, "-m", "tendond.cli", *arguments]
    return subprocess.Popen(
        command, start_new_session=own_session, stdout=pipe, stderr=subprocess.STDOUT if piped else None
    )


class Output:
    """The lines that a process prints into its pipe, each given to a function by a thread.

    Args:
        process: started with `piped`.
        say: called with each line, without the program's own name.
    """

    def __init__(self, process: "subprocess.Popen[bytes]", say: Callable[[str], None]) -> None:
        self._process, self._say = process, say
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            with suppress(OSError):  # the terminal is gone: the pipe is emptied all the same
                self._say(line.decode(errors="replace").rstrip().removeprefix("tendond: "))

    def join(self) -> None:
        """Wait until the process' last line has been printed."""
        self._thread.join(JOIN_SECONDS)


def end(process: "subprocess.Popen[bytes]") -> int:
    """Terminate a process, kill it if it does not end; its exit status. A controller releases the tendons first."""
    if process.poll() is None:
        process.send_signal(signal.SIGTERM)
        try:
            process.wait(END_SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
    return process.wait()


def end_all(processes: "Iterable[subprocess.Popen[bytes]]") -> None:
    """End what still runs, one after the other, in their order; what interrupts this kills them at once."""
    running = [process for process in processes if process.poll() is None]
    try:
        for process in running:
            end(process)
    except BaseException:
        for process in running:
            if process.poll() is None:
                process.kill()
                process.wait()
        raise


def free_port(kind: socket.SocketKind = socket.SOCK_STREAM) -> int:
    """Find a port of the loopback interface that is free at this moment."""
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def tip_in_words(status: Status) -> str:
    """Format the tip's position and the largest tension; empty before the first pose."""
    if status.tip is None:
        return ""
    x, _, z = status.tip
    return f"tip x {x * 1e3:6.1f} mm, z {z * 1e3:6.1f} mm, {max(status.tension):4.1f} N"


def progress_columns() -> tuple[ProgressColumn, ...]:
    """Columns of a progress bar: phase, progress, `state` of the arm, and the time."""
    return (
        TextColumn("{task.description:<12}"),
        BarColumn(),
        TextColumn("{task.fields[state]}"),
        TimeElapsedColumn(),
    )
