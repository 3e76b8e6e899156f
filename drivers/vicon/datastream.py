"""Frames from the Vicon DataStream SDK through the `motioncapture` package, in a process of its own.

The package's `connect` blocks for ever without a server and cannot be interrupted, so a child process calls it and
hands each frame on as a line of JSON; a child that says nothing is ended. Run as a module, this file is that child.
"""

import ctypes
import importlib.util
import json
import select
import signal
import subprocess
import sys
import time
from collections import Counter

import numpy as np

from tendond.drivers.vicon.frames import Frame
from tendond.drivers.vicon.geometry import Placement, rotation_from_quaternion
from tendond.drivers.vicon.udp import POLL_SECONDS, ViconError
from tendond.schemas.config_vicon import ViconSection

DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG of prctl(2)
LONGEST_LINE = 65536


class DataStreamSource:
    """A child process that is connected to the server.

    Args:
        section: [vicon].

    Raises:
        ViconError: the package is not installed.

    Attributes:
        counts: lines that could not be read, by reason.
        packets: all that came.
    """

    def __init__(self, section: ViconSection) -> None:
        if importlib.util.find_spec("motioncapture") is None:
            raise ViconError(
                "vicon.source = 'datastream' needs the motioncapture package: pip install 'tendond[vicon-sdk]', or use"
                " vicon.source = 'udp'"
            )
        self._server = section.server
        self._timeout = section.server_timeout
        self._started = time.monotonic()
        self.counts: Counter[str] = Counter()
        self.packets = 0
        self._buffer = b""
        self._child = subprocess.Popen(
            [sys.executable, "-m", __name__, section.server], stdout=subprocess.PIPE, stdin=subprocess.DEVNULL
        )

    def close(self) -> None:
        """End the child."""
        self._child.kill()
        self._child.communicate()

    def receive(self) -> Frame | None:
        """The next frame; none when none came for a moment.

        Raises:
            ViconError: no first frame in time, or the connection has ended.
        """
        assert self._child.stdout is not None
        if b"\n" not in self._buffer:
            ready, _, _ = select.select([self._child.stdout], [], [], POLL_SECONDS)
            if not ready:
                if not self.packets and time.monotonic() - self._started > self._timeout:
                    raise ViconError(
                        f"no frame from the DataStream server {self._server} in {self._timeout:g} s: is Tracker running"
                        " there, and vicon.server right?"
                    )
                return None
            data = self._child.stdout.read1(LONGEST_LINE)  # type: ignore[attr-defined]
            if not data:
                raise ViconError(f"the connection to the DataStream server {self._server} has ended")
            self._buffer += data
        line, newline, rest = self._buffer.partition(b"\n")
        if not newline:
            return None
        self._buffer = rest
        self.packets += 1
        return self._frame(line, time.monotonic_ns())

    def _frame(self, line: bytes, stamp_ns: int) -> Frame | None:
        try:
            number, objects = json.loads(line)
            placements = {
                name: Placement(np.array([x, y, z], dtype=np.float64), rotation_from_quaternion(qw, qx, qy, qz))
                for name, (x, y, z, qw, qx, qy, qz) in objects.items()
            }
        except (ValueError, TypeError, AttributeError):
            self.counts["garbage"] += 1
            return None
        if not all(np.all(np.isfinite(one.position)) for one in placements.values()):
            self.counts["not finite"] += 1
            return None
        return Frame(number, placements, stamp_ns)


def main(server: str) -> None:
    """The child: connect, then a line per frame: its number, and [x, y, z (m), qw, qx, qy, qz] by name."""
    ctypes.CDLL(None).prctl(DIE_WITH_PARENT, signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    import motioncapture

    client = motioncapture.connect("vicon", {"hostname": server})
    number = 0
    while True:
        client.waitForNextFrame()
        objects = {}
        for name, body in client.rigidBodies.items():
            q = body.rotation
            objects[name] = [*map(float, body.position), q.w, q.x, q.y, q.z]
        print(json.dumps([number, objects]), flush=True)
        number += 1


if __name__ == "__main__":
    main(sys.argv[1])
