"""Notifications to systemd (Type=notify): ready, status, watchdog, stopping.

The protocol is a datagram of NAME=VALUE lines to the socket that NOTIFY_SOCKET names; see sd_notify(3) and
sd_watchdog_enabled(3). Without that variable, outside a service, nothing is sent. Nothing here raises, and nothing but
`ready` waits for systemd to read.
"""

import os
import socket
import time
from collections.abc import Mapping
from contextlib import suppress

READY_SECONDS = 5.0
SHARE = 0.5
"""Fraction of the watchdog's time after which the next ping is sent: one may get lost."""


class Supervisor:
    """The service manager's end of this process.

    Args:
        environment: with NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID; default: the process's own.
    """

    def __init__(self, environment: Mapping[str, str] = os.environ) -> None:
        self._socket = _connected(environment.get("NOTIFY_SOCKET", ""))
        self._interval = SHARE * _watchdog_seconds(environment)
        self._next_ping = 0.0 if self._socket and self._interval else float("inf")
        self._unsaid = ""
        self._ending = False

    def ready(self, status: str) -> None:
        """Notify that the process is ready; `status` describes it in one line."""
        if self._socket is not None:
            self._socket.settimeout(READY_SECONDS)
            self._send(f"READY=1\nSTATUS={_line(status)}")
            self._socket.setblocking(False)

    def status(self, status: str) -> None:
        """Set the status line that `systemctl status` shows."""
        text = f"STATUS={_line(status)}"
        self._unsaid = "" if self._send(text) else text

    def alive(self) -> None:
        """Note that a cycle was done in time; a ping is sent when it is due."""
        now = time.monotonic()
        if self._unsaid and self._send(self._unsaid):
            self._unsaid = ""
        if now >= self._next_ping and self._send("WATCHDOG=1"):
            self._next_ping = now + self._interval

    def stopping(self) -> None:
        """Notify that the process is stopping; repeated calls do nothing."""
        if not self._ending:
            self._ending = self._send("STOPPING=1")

    def close(self) -> None:
        """Close the socket; optional for a process that ends."""
        if self._socket is not None:
            self._socket.close()
            self._socket, self._next_ping = None, float("inf")

    def _send(self, text: str) -> bool:
        if self._socket is not None:
            with suppress(OSError):  # full or gone: the work goes on without it
                self._socket.send(text.encode())
                return True
        return False


def _connected(address: str) -> socket.socket | None:
    """Open a datagram socket to a path, or to a name in the abstract namespace, which begins with '@'."""
    if not address.startswith(("/", "@")):
        return None
    notify = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC)
    try:
        notify.connect("\0" + address[1:] if address[0] == "@" else address)
    except OSError:
        notify.close()
        return None
    notify.setblocking(False)
    return notify


def _watchdog_seconds(environment: Mapping[str, str]) -> float:
    """Return the silence after which this process is killed [s]; 0: never, or another process is meant."""
    if environment.get("WATCHDOG_PID", str(os.getpid())) != str(os.getpid()):
        return 0.0
    text = environment.get("WATCHDOG_USEC", "")
    return int(text) * 1e-6 if text.isdecimal() else 0.0


def _line(text: str) -> str:
    return text.replace("\n", "; ")
