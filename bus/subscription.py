"""A client's subscription to one kind of message: decoded, bounded, without waiting."""

import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any, Generic, TypeVar

import zenoh

from tendond.schemas.messages import Message
from tendond.schemas.wire import UnreadableError, decode

M = TypeVar("M", bound=Message)

LOCKSTEP_POLL_SECONDS = 50e-6
"""Time between two looks for a message where controller and simulator wait for each other [s]."""


class Subscription(Generic[M]):
    """The last messages published on a key; ends with its session, or by `close`.

    Args:
        session: the Zenoh session.
        expression: full key, see `schemas.keys.key`.
        kind: class of the messages.
        size: messages kept between two calls; the oldest are dropped.
        arrived: set when a message has arrived and can be taken, on Zenoh's thread.

    Attributes:
        unreadable: number of samples that could not be decoded, by reason.
    """

    def __init__(
        self,
        session: zenoh.Session,
        expression: str,
        kind: type[M],
        size: int = 1,
        arrived: threading.Event | None = None,
    ) -> None:
        self.unreadable: Counter[str] = Counter()
        self._take: Callable[[], zenoh.Sample | None]
        self._kind = kind
        self._size = size
        self._subscriber: zenoh.Subscriber[Any]
        if arrived is None:
            ring = session.declare_subscriber(expression, zenoh.handlers.RingChannel(size))
            self._subscriber, self._take = ring, ring.try_recv
            return
        kept: deque[zenoh.Sample] = deque(maxlen=size)

        def keep(sample: zenoh.Sample) -> None:
            kept.append(sample)
            arrived.set()

        self._subscriber = session.declare_subscriber(expression, keep)
        self._take = lambda: kept.popleft() if kept else None

    def __iter__(self) -> Iterator[M]:
        """Take the messages that have arrived, oldest first; ends after `size` samples, whatever keeps arriving."""
        for _ in range(self._size):
            if (sample := self._take()) is None:
                return
            try:
                if sample.kind != zenoh.SampleKind.PUT:
                    raise UnreadableError("deleted")
                yield decode(self._kind, sample.payload.to_bytes())
            except UnreadableError as error:
                self.unreadable[error.reason] += 1

    def newest(self) -> M | None:
        """Take the messages that have arrived and return the last; none if there is none."""
        newest = None
        for message in self:
            newest = message
        return newest

    def close(self) -> None:
        """Undeclare the subscription."""
        self._subscriber.undeclare()


def listen(
    session: zenoh.Session, expression: str, kind: type[M], receive: Callable[[M, float], None]
) -> zenoh.Subscriber[None]:
    """Pass on each message as it arrives, on Zenoh's thread; what cannot be decoded is dropped.

    Args:
        session: the Zenoh session.
        expression: full key, see `schemas.keys.key`.
        kind: class of the messages.
        receive: called with the message, and the monotonic time at which it arrived [s].
    """

    def arrived(sample: zenoh.Sample) -> None:
        now = time.monotonic()
        with suppress(UnreadableError):
            receive(decode(kind, sample.payload.to_bytes()), now)

    return session.declare_subscriber(expression, arrived)
