"""The Vicon driver as a process: frames in, tip poses on the bus."""

import time
from collections import Counter
from collections.abc import Callable
from typing import Protocol

from tendond.drivers.session import StoppedError, open_client
from tendond.drivers.vicon.datastream import DataStreamSource
from tendond.drivers.vicon.frames import Frame, Sequencer
from tendond.drivers.vicon.poses import PoseBuilder
from tendond.drivers.vicon.udp import UdpSource
from tendond.notify import Supervisor
from tendond.schemas.config import RigConfig
from tendond.schemas.config_vicon import ViconSection
from tendond.schemas.keys import TIP_POSE, key
from tendond.schemas.messages import ENCODING
from tendond.schemas.wire import encode

CONNECT_SECONDS = 120.0
REPORT_SECONDS = 10.0
"""Between two reports of what was odd; there is none when nothing was."""


class Source(Protocol):
    """Where frames come from."""

    counts: Counter[str]
    packets: int

    def receive(self) -> Frame | None:
        """The next frame; none when none came for a moment."""

    def close(self) -> None:
        """Let go of it."""


class ViconDriver:
    """Poses from Vicon Tracker.

    Args:
        config: of the rig.
        section: its [vicon].
        stopped: true when the process is to end.
        say: a line for people.
        supervisor: is told when Tracker can be heard and the controller reached, and by each look that it is alive.
    """

    def __init__(
        self,
        config: RigConfig,
        section: ViconSection,
        stopped: Callable[[], bool],
        say: Callable[[str], None],
        supervisor: Supervisor | None = None,
    ) -> None:
        self._config = config
        self._section = section
        self._stopped = stopped
        self._say = say
        self._supervisor = supervisor or Supervisor({})
        self._builder = PoseBuilder(section, config.rod.gravity)
        wanted = {section.tip, section.base} - {""}
        self._sequencer = Sequencer(frozenset(wanted))
        self._heard = time.monotonic()
        self._silent = False
        self._objections: tuple[str, ...] = ("no frame yet",)
        self._reported: Counter[str] = Counter()

    def run(self) -> None:
        """Publish until stopped.

        Raises:
            BusError: no controller.
            ViconError: the frames' source cannot be used.
        """
        section = self._section
        source: Source = UdpSource(section) if section.source == "udp" else DataStreamSource(section)
        try:
            with open_client(self._config.bus.endpoint, CONNECT_SECONDS, self._stopped) as session:
                expression = key(self._config.rig.name, TIP_POSE)
                publisher = session.declare_publisher(expression, encoding=ENCODING, express=True)
                report = time.monotonic() + REPORT_SECONDS
                self._heard = time.monotonic()
                self._supervisor.ready("connected; no frame yet")
                while not self._stopped():
                    self._supervisor.alive()
                    block = source.receive()
                    self._listen(block is not None, source)
                    for frame in [] if block is None else self._sequencer.add(block):
                        pose = self._builder.build(frame)
                        self._tell()
                        if pose is not None:
                            publisher.put(encode(pose))
                    if time.monotonic() > report:
                        self._report(source)
                        report = time.monotonic() + REPORT_SECONDS
        except StoppedError:
            return
        finally:
            self._supervisor.stopping()
            source.close()
            self._report(source)

    def _listen(self, heard: bool, source: Source) -> None:
        """Say when the stream falls silent, and when it is back."""
        now = time.monotonic()
        if heard:
            self._heard = now
            if self._silent:
                self._say("Tracker is heard again")
                self._silent = False
        elif not self._silent and now - self._heard > self._section.silence:
            self._silent = True
            cause = ", ".join(f"{count} {reason}" for reason, count in source.counts.items())
            self._say(
                f"nothing from Tracker for {self._section.silence:g} s"
                + (f"; what came was no packet of its: {cause}" if cause else "")
            )

    def _tell(self) -> None:
        """Say when the poses become invalid, and when they are valid again."""
        if self._builder.objections == self._objections:
            return
        self._objections = self._builder.objections
        if self._objections:
            self._say(f"no valid pose: {', '.join(self._objections)}")
        else:
            self._say("the tip is seen")

    def _report(self, source: Source) -> None:
        """Say what was odd since the last report."""
        total = source.counts + self._sequencer.counts + self._builder.counts
        new = total - self._reported
        if new:
            self._say("since the last report: " + ", ".join(f"{count} {reason}" for reason, count in new.items()))
        self._reported = total
