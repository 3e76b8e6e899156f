"""Frames of any system that the `motioncapture` package knows, in a process of its own.

The package's `connect` blocks for ever without a server, and so does its wait for a frame once the server has gone;
neither can be interrupted. So a child process calls them (`sdk_child.py`), and one that says nothing is
ended and another one started.
"""

import json
import os
import select
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Mapping

import numpy as np

from tendond.drivers.mocap.frames import POLL_SECONDS, STALE_NS, Frame
from tendond.drivers.mocap.geometry import Placement, rotation_from_quaternion
from tendond.drivers.mocap.updates import Numbers, Updates
from tendond.drivers.vicon.packet import NOT_FINITE
from tendond.schemas.config.mocap import MocapSection
from tendond.schemas.config.vicon import ViconSection

LONGEST_LINE = 65536
RECONNECT_SECONDS = 2.0
"""Time without a frame (or `silence`, if longer) after which the child counts as hung [s]."""

PAUSE_SECONDS = 1.0
"""Pause between the end of a child and the start of the next one [s]."""


class SdkSource:
    """A child process that is connected to the server; one that hangs or ends is replaced.

    Args:
        section: [mocap] or [vicon].

    Attributes:
        counts: lines that could not be read, by reason.
        packets: all that came.
    """

    def __init__(self, section: ViconSection) -> None:
        self._section = section
        self._server = server_of(section)
        hold = section.polled_for
        self._updates = None if hold is None else Updates(section.tip, {section.base} - {""}, round(1e9 * hold))
        self._wanted = {section.tip, section.base} - {""}
        self.counts: Counter[str] = Counter()
        self.packets = 0
        self._number = 0
        self._news: list[str] = []
        self._buffer = b""
        self._heard, self._streaming = 0.0, False
        self._child: subprocess.Popen[bytes] | None = None
        self._start()

    def close(self) -> None:
        """End the child."""
        if self._child is not None:
            self._child.kill()
            self._child.communicate()
            self._child = None

    def news(self) -> list[str]:
        """Return the lines for people since the last call."""
        lines, self._news = self._news, []
        return lines

    def receive(self) -> Frame | None:
        """Return the next frame; none when none came for a moment."""
        now = time.monotonic()
        if self._child is None:
            if now < self._heard + PAUSE_SECONDS:
                time.sleep(min(POLL_SECONDS, self._heard + PAUSE_SECONDS - now))
                return None
            self._start()
        assert self._child is not None
        assert self._child.stdout is not None
        if b"\n" not in self._buffer:
            ready, _, _ = select.select([self._child.stdout], [], [], POLL_SECONDS)
            if not ready:
                self._lose_patience()
                return None
            data = os.read(self._child.stdout.fileno(), LONGEST_LINE)
            if not data:
                self._replace(f"the connection to {self._server} has ended")
                return None
            self._buffer += data
        line, newline, rest = self._buffer.partition(b"\n")
        if not newline:
            return None
        self._buffer = rest
        self.packets += 1
        self._heard, self._streaming = time.monotonic(), True
        return self._frame(line)

    def _start(self) -> None:
        """Start a child."""
        self._buffer = b""
        self._heard, self._streaming = time.monotonic(), False
        kind, settings = self._section.connection
        command = [sys.executable, "-m", "tendond.drivers.mocap.sdk_child", kind, json.dumps(settings)]
        self._child = subprocess.Popen(command, stdout=subprocess.PIPE, stdin=subprocess.DEVNULL)

    def _lose_patience(self) -> None:
        """Replace a child that has been silent for too long."""
        section = self._section
        if self._streaming:
            patience = max(section.silence, RECONNECT_SECONDS)
            reason = f"no further frame from {self._server} in {patience:g} s"
        else:
            patience = section.server_timeout
            reason = (
                f"no frame from {self._server} in {patience:g} s: is {section.station} running there, and"
                f" {section.key}.server right?"
            )
        if time.monotonic() - self._heard > patience:
            self._replace(reason)

    def _replace(self, reason: str) -> None:
        """End the child; another is started after a pause."""
        self._news.append(f"{reason}; connecting again")
        self.close()
        self._heard = time.monotonic()

    def _frame(self, line: bytes) -> Frame | None:
        """Build the frame of the robot's objects alone: of the others nothing is looked at."""
        try:
            message = json.loads(line)
            if "error" in message:
                self._news.append(f"{self._section.station}: {message['error']}")
                return None
            stamp_ns, objects = int(message["stamp_ns"]), message["objects"]
            numbers = {name: _numbers(objects[name]) for name in self._wanted & objects.keys()}
        except (ValueError, TypeError, AttributeError, KeyError):
            self.counts["garbage"] += 1
            return None
        if time.monotonic_ns() - stamp_ns > STALE_NS:
            self.counts["stale"] += 1
            return None
        measured: Mapping[str, Numbers | None] = numbers
        faults: dict[str, str] = {}
        if self._updates is not None:
            if (taken := self._updates.take(numbers, stamp_ns)) is None:
                return None
            measured, faults = taken[0], dict(taken[1])
            self._number += 1
        else:
            self._number = self.packets
        placements: dict[str, Placement | None] = {}
        for name, one in measured.items():
            found = None if one is None else _placement(one)
            placements[name] = None if isinstance(found, str) else found
            if isinstance(found, str):
                faults[name] = found
        return Frame(self._number, placements, stamp_ns, faults)


def server_of(section: ViconSection) -> str:
    """Name the server and its address, for people."""
    if isinstance(section, MocapSection) and section.system != "vicon":
        host, port = section.host_and_port
        return f"{section.station} at {host}:{port}"
    return f"the DataStream server {section.connection[1]['hostname']}"


def _numbers(values: list[float]) -> Numbers:
    """Return seven numbers as a body has them.

    Raises:
        ValueError, TypeError: these are not seven numbers.
    """
    x, y, z, qw, qx, qy, qz = (float(number) for number in values)
    return x, y, z, qw, qx, qy, qz


def _placement(numbers: Numbers) -> Placement | str | None:
    """Return the placement of an object; none without a unit quaternion, if it is not tracked; else what is wrong."""
    x, y, z, qw, qx, qy, qz = numbers
    if not np.all(np.isfinite(numbers)):
        return NOT_FINITE
    try:
        rotation = rotation_from_quaternion(qw, qx, qy, qz)
    except ValueError:
        return None
    return Placement(np.array([x, y, z]), rotation)
