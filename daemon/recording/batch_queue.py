"""The bounded queue between the loop and the recorder's thread, which it wakes as seldom as it can."""

import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import Any

from pydantic import BaseModel

from tendond.daemon.recording.channels import Channel

WAKE_AT = 4
"""Batches in the queue, at which the thread is woken."""

Message = tuple[Channel[Any], BaseModel | Callable[[], BaseModel], int]
"""Channel; message, or what makes it, called in the recorder's thread; log time [ns]."""

_Batch = tuple[int, Callable[..., list[Message]], tuple[Any, ...]]
"""Number of messages, what makes them, of what. A file of the run may end before a batch, not within."""


class BatchQueue:
    """Queue of batches of messages, bounded by the number of messages: any thread puts, one takes.

    Attributes:
        lock: of the counters here and in the recorder; held for a few instructions, never over I/O.
        accepting: false: what is put is refused.
        queued: messages that were put, without those that were refused or left out; refused: those that were refused.
    """

    def __init__(self, size: int) -> None:
        self.lock = threading.Lock()
        self.accepting = False
        self.queued = self.refused = 0
        self._size = size
        self._batches: deque[_Batch] = deque()
        self._bell: SimpleQueue[None] = SimpleQueue()  # rung when the thread should look into the queue
        self._taken = 0  # the taking thread alone writes it
        self._resting = False

    def __len__(self) -> int:
        """Return the number of batches that wait."""
        return len(self._batches)

    @property
    def waiting(self) -> int:
        """Messages that wait."""
        return self.queued - self._taken

    def put(self, count: int, make: Callable[..., list[Message]], arguments: tuple[Any, ...]) -> bool:
        """Queue a batch of `count` messages, or refuse all of them."""
        with self.lock:
            if not self.accepting or self.queued - self._taken + count > self._size:
                self.refused += count
                return False
            self.queued += count
            self._batches.append((count, make, arguments))
            if self._resting or len(self._batches) == WAKE_AT:
                self._bell.put(None)
            return True

    def close(self) -> None:
        """Refuse what comes from now on, and wake the thread."""
        with self.lock:
            if self.accepting:
                self.accepting = False
                self._bell.put(None)

    def wait(self, seconds: float) -> None:
        """Wait until the thread is woken, at most so long."""
        with suppress(Empty):
            self._bell.get(timeout=seconds)

    def rest(self, seconds: float) -> None:
        """Wait until the next batch is put, at most so long."""
        self._resting = True
        self.wait(seconds)
        self._resting = False

    def take(self) -> list[Message]:
        """Make the messages of the oldest batch, and correct the count by those that are left out or come after all."""
        count, make, arguments = self._batches.popleft()
        messages = make(*arguments)
        if len(messages) != count:
            with self.lock:
                self.queued -= count - len(messages)
        return messages

    def count_taken(self, messages: int) -> None:
        """Count messages as no longer waiting."""
        self._taken += messages
