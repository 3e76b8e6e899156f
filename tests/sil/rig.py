"""Real processes on real Zenoh over loopback, each ended by its own process id."""

import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import zenoh

from tendond.bus.client import BusError, open_client
from tendond.bus.operator import ask
from tendond.schemas.keys import control_key
from tendond.schemas.messages import Mode, Status
from tendond.schemas.requests import ControlAction, ControlReply, ControlRequest
from tendond.schemas.wire import encode
from tests.sil.background import running

PATIENCE_SECONDS = 120.0

TEMPORARY = ("rests", "does not rest", "seen at rest", "ms old")
"""Why arming may be refused for a moment: the tip still swings, or another test keeps the processors busy."""

FLOOD = 1000.0
"""Queries a second."""

PATIENT = """
[faults]
pose_timeout = 1.0
tendon_timeout = 1.2
overrun_time = 0.9
"""
"""Thresholds of time, where a test has none of its own: the machine that tests may stand still for a while."""


class Rig:
    """A folder with a configuration on a free port, and the processes started in it.

    Args:
        folder: an empty one.
        extra: more of the configuration; with [faults] in it, `PATIENT` is left out.
    """

    def __init__(self, folder: Path, extra: str = "") -> None:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.endpoint = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
        self.folder = folder
        self.name = "sil"
        self.config = folder / "rig.toml"
        self.config.write_text(f'[rig]\nname = "{self.name}"\n[bus]\nendpoint = "{self.endpoint}"\n{extra}')
        if "[commissioning]" not in extra:  # two seconds in each test, that has tests of its own
            with self.config.open("a") as file:
                file.write("\n[commissioning]\nprobe = false\n")
        if "[faults]" not in extra:
            with self.config.open("a") as file:
                file.write(PATIENT)
        self.processes: list[subprocess.Popen[str]] = []
        self.started: dict[str, subprocess.Popen[str]] = {}
        """The newest process of each command."""

    def start(self, *arguments: str) -> subprocess.Popen[str]:
        """Start a tendond process, with its output in pipes."""
        process = subprocess.Popen(
            [sys.executable, "-m", "tendond.cli", *arguments, "--config", str(self.config)],
            cwd=self.folder,
            stderr=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.processes.append(process)
        self.started[arguments[0]] = process
        return process

    def command(self, *arguments: str) -> "subprocess.CompletedProcess[str]":
        """Run an operator's command to its end."""
        command = [sys.executable, "-m", "tendond.cli", *arguments, "--config", str(self.config)]
        return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_SECONDS)

    def controller(self, *arguments: str) -> subprocess.Popen[str]:
        """Start the controller, logging to run.mcap."""
        return self.start("run", "--log", str(self.folder / "run.mcap"), *arguments)

    def session(self) -> zenoh.Session:
        """Open a client session, once the controller listens."""
        return open_client(self.endpoint, PATIENCE_SECONDS)

    def ask(self, session: zenoh.Session, action: ControlAction) -> ControlReply:
        """Send a request until the controller replies; return the reply."""
        deadline = time.monotonic() + PATIENCE_SECONDS
        while True:
            try:
                return ask(session, self.name, action)
            except BusError:
                if time.monotonic() > deadline:
                    raise

    def status(self, session: zenoh.Session) -> Status:
        """Return the controller's status."""
        reply = self.ask(session, ControlAction.STATUS)
        assert reply.status is not None
        return reply.status

    def until(self, session: zenoh.Session, wanted: Callable[[Status], bool]) -> Status:
        """Wait for a status."""
        deadline = time.monotonic() + PATIENCE_SECONDS
        while not wanted(status := self.status(session)):
            assert time.monotonic() < deadline, status
            time.sleep(0.02)
        return status

    def pass_ticks(self, session: zenoh.Session, count: int) -> Status:
        """Wait for so many cycles of the controller; return the status after them."""
        start = self.status(session).tick
        return self.until(session, lambda status: status.tick > start + count)

    def arm(self, session: zenoh.Session) -> None:
        """Arm, once there are poses and the tip rests, and wait until it tracks."""
        self.until(session, lambda status: status.tip is not None)
        deadline = time.monotonic() + PATIENCE_SECONDS
        while not (reply := self.ask(session, ControlAction.ARM)).done:
            assert any(words in reply.message for words in TEMPORARY), reply.message
            assert time.monotonic() < deadline, reply.message
            time.sleep(0.1)
        self.until(session, lambda status: status.mode is Mode.TRACKING)

    def end(self, process: subprocess.Popen[str], number: int = signal.SIGTERM) -> tuple[int, str]:
        """Signal a process and wait; return its exit status and its standard error."""
        process.send_signal(number)
        _, said = process.communicate(timeout=30.0)
        return process.returncode, said


@contextmanager
def rig(folder: Path, extra: str = "") -> Iterator[Rig]:
    """Yield a rig whose processes end with the block."""
    one = Rig(folder, extra)
    try:
        yield one
    finally:
        for process in one.processes:
            if process.poll() is None:
                process.kill()
            process.communicate()


@contextmanager
def flooded(one: Rig, session: zenoh.Session) -> Iterator[list[int]]:
    """Query the status at `FLOOD`, or as fast as the machine can, without waiting; the number of queries so far."""
    ending, put = threading.Event(), [0]
    payload = encode(ControlRequest(action=ControlAction.STATUS))

    def flood() -> None:
        began = time.monotonic()
        while not ending.is_set():
            while put[0] < (time.monotonic() - began) * FLOOD and not ending.is_set():
                session.get(
                    control_key(one.name, "status"),
                    lambda reply: None,
                    payload=payload,
                    timeout=1.0,
                )
                put[0] += 1
            time.sleep(0.002)

    with running(flood, ending):
        yield put
