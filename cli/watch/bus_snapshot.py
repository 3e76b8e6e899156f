"""Snapshot of the bus: the newest message of each kind, its time and rate, and the tip's trail."""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from tendond.schemas.base import Vector3
from tendond.schemas.messages import Message, Status, TendonCommand, TendonState, TipPose

FRAMES_PER_SECOND = 10.0
TRAIL_POSES = 1000
ERRORS = 200
RATE_SECONDS = 4.0
"""Time over which a rate is measured: a camera's jitter of 2 ms is then 0.1 % of it."""

SILENT_SECONDS = 1.0
"""Time without a command after which there is no controller: it sends one each cycle, armed or not."""

STATUS_SILENT_SECONDS = 2.5
"""The same for its status, sent each second."""


@dataclass
class Stream:
    """Newest message of a kind, its arrival time [s], and the numbers and stamps of those before.

    Messages are taken from the bus a frame at a time, and only the newest of a frame may be left: their arrival says
    little about their rate, unlike their publisher's stamps and sequence numbers.
    """

    message: Message | None = None
    at: float = -math.inf
    _numbers: deque[tuple[float, float, int]] = field(default_factory=deque)
    """Arrival [s], stamp [s] and sequence number."""

    def add(self, message: Message, now: float) -> None:
        """Add a message that arrived at `now` [s]."""
        last = self.message
        if last is not None and (message.seq < last.seq or message.source != last.source):  # another publisher
            self._numbers.clear()
        self._numbers.append((now, 1e-9 * message.stamp_ns, message.seq))
        while self._numbers[0][0] < now - RATE_SECONDS:
            self._numbers.popleft()
        self.message, self.at = message, now

    def rate(self, now: float) -> float:
        """Rate at which the publisher sends [Hz], by its stamps over the last seconds; 0 if it has stopped."""
        recent = [one for one in self._numbers if one[0] >= now - RATE_SECONDS]
        if len(recent) < 2:
            return 0.0
        numbers = [float(seq) for _, _, seq in recent]
        times = [stamp for _, stamp, _ in recent]
        if times[-1] <= times[0]:  # a publisher without a clock
            times = [at for at, _, _ in recent]
        return slope(times, numbers) if times[-1] > times[0] else 0.0

    @property
    def span(self) -> float:
        """Time over which a rate can be measured [s]: between the first and the last stamp."""
        return self._numbers[-1][1] - self._numbers[0][1] if self._numbers else 0.0


def slope(x: Sequence[float], y: Sequence[float]) -> float:
    """Return the slope of the line through points that fits best by least squares; x has at least two values."""
    mean = sum(x) / len(x)
    return sum((a - mean) * b for a, b in zip(x, y, strict=True)) / sum((a - mean) ** 2 for a in x)


class BusSnapshot:
    """Messages of a rig, as the live view shows them."""

    def __init__(self) -> None:
        self.status_stream, self.pose_stream = Stream(), Stream()
        self.command_stream, self.tendons_stream = Stream(), Stream()
        self.trail: deque[Vector3] = deque(maxlen=TRAIL_POSES)
        self.errors: deque[float] = deque(maxlen=ERRORS)

    def add(self, message: Message, now: float) -> None:
        """Add a message that arrived at `now` [s]."""
        match message:
            case Status():
                self.status_stream.add(message, now)
            case TipPose():
                self.pose_stream.add(message, now)
                if message.valid:
                    self.trail.append(message.position)
            case TendonCommand():
                self.command_stream.add(message, now)
            case TendonState():
                self.tendons_stream.add(message, now)

    def tick(self, now: float) -> None:
        """Advance by a frame, after its messages: record the error while poses arrive."""
        if self.error is not None and self.pose_stream.at > now - SILENT_SECONDS:
            self.errors.append(self.error)

    @property
    def status(self) -> Status | None:
        """Newest message of its kind; none before the first."""
        message = self.status_stream.message
        return message if isinstance(message, Status) else None

    @property
    def pose(self) -> TipPose | None:
        """Newest message of its kind; none before the first."""
        message = self.pose_stream.message
        return message if isinstance(message, TipPose) else None

    @property
    def command(self) -> TendonCommand | None:
        """Newest message of its kind; none before the first."""
        message = self.command_stream.message
        return message if isinstance(message, TendonCommand) else None

    @property
    def tendons(self) -> TendonState | None:
        """Newest state of the servos or the simulator; none before the first."""
        message = self.tendons_stream.message
        return message if isinstance(message, TendonState) else None

    @property
    def error(self) -> float | None:
        """Distance of the tip from the target [m]."""
        if self.status is None or self.pose is None:
            return None
        return math.dist(self.pose.position, self.status.target)

    def is_silent(self, now: float) -> bool:
        """Check that no controller is heard, by its status where an access list hides its commands."""
        if self.command_stream.message is None:
            return self.status_stream.at < now - STATUS_SILENT_SECONDS
        return self.command_stream.at < now - SILENT_SECONDS
