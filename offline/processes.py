"""Child processes: `tendond` commands that are started and ended, and their progress."""

import signal
import socket
import subprocess
import sys

from rich.progress import BarColumn, ProgressColumn, TextColumn, TimeElapsedColumn

from tendond.schemas.messages import Status

START_SECONDS = 120.0
"""Timeout for a process to start; it may have to compile its kernels."""

END_SECONDS = 10.0
POLL_SECONDS = 0.1


def start(*arguments: str, own_session: bool = False) -> "subprocess.Popen[bytes]":
    """Start `tendond` with these arguments; in its own session it does not receive the terminal's Ctrl-C."""
    return subprocess.Popen([sys.executable, "-m", "tendond.cli", *arguments], start_new_session=own_session)


def end(process: "subprocess.Popen[bytes]") -> int:
    """Terminate a process, kill it if it does not end; its exit status. A controller releases the tendons first."""
    if process.poll() is None:
        process.send_signal(signal.SIGTERM)
        try:
            process.wait(END_SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
    return process.wait()


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
