"""Processes of our own that a command starts and ends, and what they answer."""

import signal
import socket
import subprocess
import sys

from rich.progress import BarColumn, ProgressColumn, TextColumn, TimeElapsedColumn

from tendond.schemas.messages import Status

START_SECONDS = 120.0
"""For a process to come up; it may have to compile its kernels."""

END_SECONDS = 10.0
POLL_SECONDS = 0.1


def start(*arguments: str, own_session: bool = False) -> "subprocess.Popen[bytes]":
    """A `tendond` with these arguments; in a session of its own it does not hear of Ctrl-C in the terminal."""
    return subprocess.Popen([sys.executable, "-m", "tendond.cli", *arguments], start_new_session=own_session)


def end(process: "subprocess.Popen[bytes]") -> int:
    """Ask a process to end, and make it when it does not; its exit status. A controller releases the tendons first."""
    if process.poll() is None:
        process.send_signal(signal.SIGTERM)
        try:
            process.wait(END_SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
    return process.wait()


def free_port(kind: socket.SocketKind = socket.SOCK_STREAM) -> int:
    """Of the loopback interface, at this moment."""
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def tip_in_words(status: Status) -> str:
    """Where the tip is and how hard the tendons pull; empty before the first pose."""
    if status.tip is None:
        return ""
    x, _, z = status.tip
    return f"tip x {x * 1e3:6.1f} mm, z {z * 1e3:6.1f} mm, {max(status.tension):4.1f} N"


def progress_columns() -> tuple[ProgressColumn, ...]:
    """What is going on, how far it is, `seen` of the arm, and the time."""
    return (
        TextColumn("{task.description:<12}"),
        BarColumn(),
        TextColumn("{task.fields[seen]}"),
        TimeElapsedColumn(),
    )
