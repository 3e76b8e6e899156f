"""The service manager's end of the notify protocol: a socket that a test has bound."""

import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tendond.bus.systemd import Supervisor
from tests.sil.rig import PATIENCE_SECONDS

WATCHDOG_SECONDS = 0.4
PING = "WATCHDOG=1"


class Manager:
    """A notify socket in a folder; processes started while it is `in_charge` notify it."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "notify"
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(str(self.path))
        self.received: list[str] = []
        self._supervisors: list[Supervisor] = []
        self._reader: threading.Thread | None = None

    def close(self) -> None:
        for supervisor in self._supervisors:
            supervisor.close()
        if self._reader is not None:
            with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as last:
                last.sendto(b"", str(self.path))
            self._reader.join()
        self._socket.close()

    def listen(self) -> None:
        """Begin to read, as systemd does all the time."""
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        while data := self._socket.recv(4096):
            self.received += data.decode().splitlines()

    def in_charge(self, patch: pytest.MonkeyPatch, watchdog: float = WATCHDOG_SECONDS) -> None:
        """Supervise the processes that are started from now on, by systemd's variables."""
        patch.setenv("NOTIFY_SOCKET", str(self.path))
        patch.setenv("WATCHDOG_USEC", str(round(watchdog * 1e6)))
        self.listen()

    def supervisor(self, **environment: str) -> Supervisor:
        """Return a supervisor of this process, with a watchdog of a millisecond."""
        own = Supervisor({"NOTIFY_SOCKET": str(self.path), "WATCHDOG_USEC": "1000", **environment})
        self._supervisors.append(own)
        return own

    def hear(self, seconds: float) -> list[str]:
        """Return the lines that come within a time [s]."""
        before = len(self.received)
        time.sleep(seconds)
        return self.received[before:]

    def await_line(self, wanted: str, after: int = 0) -> None:
        """Wait for a line that begins so, among those after the first so many."""
        until = time.monotonic() + PATIENCE_SECONDS
        while not any(line.startswith(wanted) for line in self.received[after:]):
            assert time.monotonic() < until, (wanted, self.received)
            time.sleep(0.02)


@pytest.fixture
def manager(tmp_path: Path) -> Iterator[Manager]:
    one = Manager(tmp_path)
    yield one
    one.close()
