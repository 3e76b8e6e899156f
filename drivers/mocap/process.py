"""Process of a camera's driver: frames in, tip poses on the bus."""

import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from tendond.bus.client import StoppedError
from tendond.bus.identity import new_source
from tendond.drivers.host import Host, await_controller
from tendond.drivers.mocap.frames import Sequencer
from tendond.drivers.mocap.geometry import placed
from tendond.drivers.mocap.poses import PoseBuilder
from tendond.drivers.mocap.source import FrameSource, open_source
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.vicon import ViconSection
from tendond.schemas.keys import TIP_POSE, key
from tendond.schemas.messages import ENCODING
from tendond.schemas.wire import encode

REPORT_SECONDS = 10.0
"""Time between two reports of irregular frames [s]; without any there is none."""

LINES_AT_ONCE, LINE_SECONDS = 12, 5.0
"""Number of lines at once, and time after which one more is allowed [s]: a flickering tip must not fill the log."""


class LimitedLog:
    """Lines for people at a bounded rate; the rest are counted.

    Args:
        say: a line for people.

    Attributes:
        withheld: lines that were not said.
    """

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self._left = float(LINES_AT_ONCE)
        self._at = time.monotonic()
        self.withheld = 0

    def __call__(self, line: str) -> bool:
        """Log a line within the allowed rate; return whether it was logged."""
        now = time.monotonic()
        self._left = min(self._left + (now - self._at) / LINE_SECONDS, LINES_AT_ONCE)
        self._at = now
        if self._left < 1.0:
            self.withheld += 1
            return False
        self._left -= 1.0
        self._say(line)
        return True


class MocapDriver:
    """Poses from the cameras.

    Args:
        config: configuration of the rig.
        section: its [mocap] or [vicon].
        host: surroundings of the process.
        folder: of the configuration, to which names of files are relative.
    """

    def __init__(self, config: RigConfig, section: ViconSection, host: Host, folder: Path = Path()) -> None:
        self._config = config
        self._section = section
        self._host = host
        self._folder = folder
        self._log = LimitedLog(host.say)
        self._builder = PoseBuilder(section, config.rod.base_gravity, placed(config.rod.base))
        wanted = {section.tip, section.base} - {""}
        self._sequencer = Sequencer(frozenset(wanted))
        self._heard = time.monotonic()
        self._silent = False
        self._objections: tuple[str, ...] = ("no frame yet",)
        self._tilted = False
        self._unheard: Counter[str] = Counter()
        self._reported: Counter[str] = Counter()

    def run(self) -> None:
        """Publish until stopped.

        Raises:
            BusError: no controller.
            ConfigError, ViconError, CameraError: the frames' source cannot be used.
        """
        source = open_source(self._section, self._folder)
        try:
            with await_controller(self._config, self._host.stopped) as session:
                expression = key(self._config.rig.name, TIP_POSE)
                publisher = session.declare_publisher(expression, encoding=ENCODING, express=True)
                identity = new_source(self._section.key)
                report = time.monotonic() + REPORT_SECONDS
                self._heard = time.monotonic()
                self._host.supervisor.ready("connected; no frame yet")
                while not self._host.stopped():
                    self._host.supervisor.alive()
                    block = source.receive()
                    for line in source.news():
                        self._log(line)
                    self._report_silence(block is not None, source)
                    for frame in [] if block is None else self._sequencer.add(block):
                        pose = self._builder.build(frame)
                        self._report_validity()
                        if pose is not None:
                            publisher.put(encode(pose.named(identity)))
                    if time.monotonic() > report:
                        self._report(source)
                        report = time.monotonic() + REPORT_SECONDS
        except StoppedError:
            return
        finally:
            self._host.supervisor.stopping()
            source.close()
            self._report(source)

    def _report_silence(self, received: bool, source: FrameSource) -> None:
        """Report when the stream falls silent, and when it is back."""
        now = time.monotonic()
        if received:
            self._heard = now
            if source.counts != self._unheard:
                self._unheard = source.counts.copy()
            if self._silent:
                self._silent = not self._log(f"packets from {self._section.station} again")
        elif not self._silent and now - self._heard > self._section.silence:
            cause = ", ".join(f"{count} {reason}" for reason, count in (source.counts - self._unheard).items())
            self._silent = self._log(
                f"nothing from {self._section.station} for {self._section.silence:g} s"
                + (f"; other packets: {cause}" if cause else "")
            )

    def _report_validity(self) -> None:
        """Report when the poses become invalid or valid again, and when the base becomes tilted or level."""
        objections, level = self._builder.objections, self._builder.level
        if objections != self._objections and self._log(
            f"no valid pose: {', '.join(objections)}" if objections else "the tip is visible"
        ):
            self._objections = objections
        if level.tilted != self._tilted and self._log(level.objection() or "the base is level"):
            self._tilted = level.tilted

    def _report(self, source: FrameSource) -> None:
        """Report the counts of irregularities since the last report."""
        total = source.counts + self._sequencer.counts + self._builder.counts
        total["lines withheld"] = self._log.withheld
        new = total - self._reported
        if new:
            self._host.say("since the last report: " + ", ".join(f"{count} {reason}" for reason, count in new.items()))
        self._reported = total
