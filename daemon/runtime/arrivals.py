"""Arrivals of a cycle: the newest readable message of each kind from its ring buffer on the bus."""

from dataclasses import dataclass, field
from typing import Generic, TypeVar

import zenoh

from tendond.schemas.messages import Message, SensorReading, SimulatorTruth, TendonState, TipPose
from tendond.schemas.wire import UnreadableError, decode

QUEUE = 64
"""Messages kept between two cycles; older ones are overwritten."""

M = TypeVar("M", bound=Message)
Subscriber = zenoh.Subscriber[zenoh.handlers.Handler[zenoh.Sample]]


@dataclass
class Arrivals:
    """Arrivals since the last cycle: the newest of each kind, and counts of unreadable payloads by reason.

    Attributes:
        pose_lag: time from a pose's capture to its arrival, by the clock of this host [s]; none in lockstep.
        readings: newest of each sensor, by its name; reading_lags: of these as `pose_lag` [s].
        others: further publishers, by key: their newest identity.
        inputs: payloads of poses, tendon states and readings that have come in, readable or not.
        detail: wrong field of the first unreadable one, and the defect.
        truth: state of the simulator; no input, and so undecoded until the command is out.
    """

    pose: TipPose | None = None
    pose_lag: float | None = None
    tendon_state: TendonState | None = None
    readings: dict[str, SensorReading] = field(default_factory=dict)
    reading_lags: dict[str, float] = field(default_factory=dict)
    inputs: int = 0
    unreadable: dict[str, int] = field(default_factory=dict)
    others: dict[str, str] = field(default_factory=dict)
    detail: str = ""
    truth: zenoh.Sample | None = None

    def decoded_truth(self) -> SimulatorTruth | None:
        """Return the truth for the log; none where there is none, or none that can be read."""
        if self.truth is None:
            return None
        try:
            return decode(SimulatorTruth, payload_of(self.truth))
        except UnreadableError:
            return None


@dataclass(frozen=True)
class Inbox(Generic[M]):
    """The subscription to a topic.

    Attributes:
        kind: class of its messages. topic: below the rig's name. subscriber: of its key, with a ring of `QUEUE`.
        prefix: of the reasons under which payloads that are no messages are counted.
    """

    kind: type[M]
    topic: str
    subscriber: Subscriber
    prefix: str = ""

    def newest(self, newest: M | None, arrivals: Arrivals, followed: str | None, *, repeating: bool) -> M | None:
        """Return the newest message of the followed publisher, or of the first that is heard; name others.

        Args:
            newest: of this cycle so far.
            arrivals: of this cycle so far; what is refused is counted there.
            followed: identity of the publisher that the cycle follows.
            repeating: see `Hub.receive`.
        """
        for _ in range(QUEUE):  # no flood keeps the loop here
            if (sample := self.subscriber.try_recv()) is None:
                break
            arrivals.inputs += 1
            try:
                message = decode(self.kind, payload_of(sample))
                if repeating and message == newest:
                    continue
                if newest is not None and message.source != newest.source:
                    if message.source != followed:
                        arrivals.others[self.topic] = message.source
                        continue
                    arrivals.others[self.topic] = newest.source
                elif newest is not None and message.seq <= newest.seq:
                    raise UnreadableError("out of order")
                newest = message
            except UnreadableError as error:
                reason = self.prefix + error.reason
                arrivals.unreadable[reason] = arrivals.unreadable.get(reason, 0) + 1
                arrivals.detail = arrivals.detail or error.detail
        return newest


def payload_of(sample: zenoh.Sample) -> bytes:
    """Return the bytes of a sample.

    Raises:
        UnreadableError: the key was deleted.
    """
    if sample.kind != zenoh.SampleKind.PUT:
        raise UnreadableError("deleted")
    return sample.payload.to_bytes()
