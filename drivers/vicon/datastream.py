"""Frames from the Vicon DataStream SDK through the `motioncapture` package, in a process of its own.

The package's `connect` blocks for ever without a server, and so does its wait for a frame once the server has gone;
neither can be interrupted. So a child process calls them (`datastream_child.py`), and one that says nothing is
ended and another one started.
"""

import importlib.util
import json
import os
import select
import subprocess
import sys
import time
from collections import Counter

import numpy as np

from tendond.drivers.vicon.frames import Frame
from tendond.drivers.vicon.geometry import Placement, rotation_from_quaternion
from tendond.drivers.vicon.packet import NOT_FINITE
from tendond.drivers.vicon.udp import POLL_SECONDS, STALE_NS
from tendond.schemas.config.rig import ConfigError
from tendond.schemas.config.vicon import ViconSection

LONGEST_LINE = 65536
RECONNECT_SECONDS = 2.0
"""Time without a frame (or vicon.silence, if longer) after which the child counts as hung [s]."""

PAUSE_SECONDS = 1.0
"""Pause between the end of a child and the start of the next one [s]."""


class DataStreamSource:
    """A child process that is connected to the server; one that hangs or ends is replaced.

    Args:
        section: [vicon].

    Raises:
        ConfigError: the package is not installed.

    Attributes:
        counts: lines that could not be read, by reason.
        packets: all that came.
    """

    def __init__(self, section: ViconSection) -> None:
        if not is_installed():
            raise ConfigError(
                "vicon.source = 'datastream' needs the motioncapture package: pip install 'tendond[vicon-sdk]', or use"
                " vicon.source = 'udp'"
            )
        self._section = section
        self._wanted = {section.tip, section.base} - {""}
        self.counts: Counter[str] = Counter()
        self.packets = 0
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
                self._replace(f"the connection to the DataStream server {self._section.server} has ended")
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
        command = [sys.executable, "-m", "tendond.drivers.vicon.datastream_child", self._section.server]
        self._child = subprocess.Popen(command, stdout=subprocess.PIPE, stdin=subprocess.DEVNULL)

    def _lose_patience(self) -> None:
        """Replace a child that has been silent for too long."""
        section = self._section
        if self._streaming:
            patience = max(section.silence, RECONNECT_SECONDS)
            reason = f"no further frame from the DataStream server {section.server} in {patience:g} s"
        else:
            patience = section.server_timeout
            reason = (
                f"no frame from the DataStream server {section.server} in {patience:g} s: is Tracker running there, and"
                " vicon.server right?"
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
                self._news.append(f"DataStream: {message['error']}")
                return None
            stamp_ns, objects = int(message["stamp_ns"]), message["objects"]
            found = {name: _placement(objects[name]) for name in self._wanted & objects.keys()}
        except (ValueError, TypeError, AttributeError, KeyError):
            self.counts["garbage"] += 1
            return None
        if time.monotonic_ns() - stamp_ns > STALE_NS:
            self.counts["stale"] += 1
            return None
        faults = {name: one for name, one in found.items() if isinstance(one, str)}
        placements = {name: None if isinstance(one, str) else one for name, one in found.items()}
        return Frame(self.packets, placements, stamp_ns, faults)


def is_installed() -> bool:
    """Return true where the `motioncapture` package is installed."""
    return importlib.util.find_spec("motioncapture") is not None


def _placement(numbers: list[float]) -> Placement | str | None:
    """Return the placement of an object; none without a unit quaternion, if it is not tracked; else what is wrong.

    Raises:
        ValueError, TypeError: these are not seven numbers.
    """
    x, y, z, *q = (float(number) for number in numbers)
    if not np.all(np.isfinite((x, y, z, *q))):
        return NOT_FINITE
    qw, qx, qy, qz = q
    try:
        rotation = rotation_from_quaternion(qw, qx, qy, qz)
    except ValueError:
        return None
    return Placement(np.array([x, y, z]), rotation)
