"""The recorder: a thread that writes the messages of a run to its files, behind a bounded queue.

    with Recorder(path, metadata, {CONFIG: config.model_dump_json()}, queue_size=4000) as recorder:
        recorder.put(CYCLE, time_ns, record)

Of a process that is killed, `StreamReader` reads everything up to the last flush, at most a second before the end.
"""

import math
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, Self

from pydantic import BaseModel

from tendond.daemon.errors import DaemonError
from tendond.daemon.recording.batch_queue import BatchQueue, Message
from tendond.daemon.recording.channels import BEGINNING, Channel, M
from tendond.daemon.recording.mcap_file import reason_of
from tendond.daemon.recording.run_files import RunFiles

FLUSH_SECONDS = 0.5
"""Longest wait of an entry before it is flushed to the disk [s]."""

LOOK_SECONDS = 0.25
"""Longest wait in the queue where the thread is not woken [s]; both together stay below the promised second."""

REST_SECONDS = 0.05
"""Longest rest of the thread for a caller who wants the interpreter [s]: a hung one must not end the log."""

FAR_BEHIND = 40
"""Batches in the queue, from which on it does not rest: the log must not fall behind by a second."""

CLOSE_SECONDS = 5.0


class RecorderError(DaemonError):
    """A log that cannot be begun: file, reason, remedy."""


class Counts(NamedTuple):
    """Counts of messages: put = written + dropped."""

    put: int
    written: int
    dropped: int


class Recorder:
    """Writes messages to an MCAP file from a thread of its own; whatever befalls the file, the caller goes on.

    Args:
        path: path of the file; an existing one is refused: a log is never overwritten.
        metadata: metadata of the run, by name: revision, versions.
        attachments: texts by name, `CONFIG` among them.
        queue_size: messages that may wait for the disk; more are dropped.
        split_bytes, split_seconds, before_file: see `RunFiles`.
    """

    def __init__(
        self,
        path: Path,
        metadata: dict[str, str],
        attachments: dict[str, str],
        queue_size: int,
        split_bytes: float = math.inf,
        split_seconds: float = math.inf,
        before_file: Callable[[Path], None] | None = None,
    ) -> None:
        self.path = path
        self._files = RunFiles(path, metadata, attachments, split_bytes, split_seconds, before_file)
        self._queue = BatchQueue(queue_size)
        self._thread = threading.Thread(target=self._run, name="recorder", daemon=True)
        self._lock = self._queue.lock  # of the next three
        self._written = self._unwritable = 0
        self._error = ""
        self._rested = math.inf
        self.rest_from = math.inf
        """Time from which on the thread leaves the interpreter to the caller, who sets it [s, monotonic clock]."""

    def __enter__(self) -> Self:
        self.open()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def open(self) -> None:
        """Begin the file: folder, metadata, attachments, channels.

        Raises:
            RecorderError: it cannot be written.
        """
        try:
            self._files.open()
        except OSError as error:
            raise RecorderError(
                f"{self.path}: no log can be written: {reason_of(error)}; choose another file"
            ) from error
        self._queue.accepting = True
        self._thread.start()

    def put(self, channel: Channel[M], log_time_ns: int, message: M | Callable[[], M]) -> bool:
        """Queue a message; never waits, never raises.

        Args:
            channel: one of `CHANNELS`.
            log_time_ns: log time of the message [ns], since the caller's epoch.
            message: or what makes it, called in the recorder's thread. It is serialised later, so neither it nor what
                it is made from may change (all of ours are frozen).

        Returns:
            Whether it was queued. If not (queue full, file ended or not open), it is counted as dropped.
        """
        return self.put_all(1, _single, channel, message, log_time_ns)

    def put_all(self, count: int, make: Callable[..., list[Message]], *arguments: Any) -> bool:
        """Queue `count` messages of one time, as `put` does: all or none.

        The recorder's thread makes them, by `make(*arguments)`, and is woken when a few calls have come together: the
        caller comes here with cold caches, and each line costs it microseconds. `make` may leave messages out, or bring
        some that an earlier one has left out: those that never come are neither written nor dropped.
        """
        return self._queue.put(count, make, arguments)

    @property
    def dropped(self) -> int:
        """Messages that are not in the file and never will be."""
        with self._lock:
            lost = self._queue.queued - self._written if self._error else self._unwritable
            return self._queue.refused + lost

    @property
    def waiting(self) -> int:
        """Messages that wait for the disk."""
        return self._queue.waiting

    @property
    def error(self) -> str:
        """Reason that ended the file early, in one line; empty without one."""
        return self._error

    def close(self, timeout: float = CLOSE_SECONDS) -> Counts:
        """Write what is queued, finish the file, stop. A second call changes nothing.

        Args:
            timeout: for the disk [s]; after that the file is left as it is, readable to its last flush.
        """
        self._queue.close()
        if self._thread.ident is not None:
            self._thread.join(timeout)
            if self._thread.is_alive():
                self._end(f"not finished within {timeout:g} s")
        with self._lock:
            put = self._queue.queued + self._queue.refused
            return Counts(put, self._written, put - self._written)

    def _run(self) -> None:
        """The writer thread."""
        try:
            self._write_until_closed()
            self._files.finish()
        except Exception as error:  # a full disk, as a rule: control goes on without a log, and says so
            self._end(reason_of(error))
            self._files.abandon()

    def _write_until_closed(self) -> None:
        unflushed = 0
        flush_at = math.inf
        accepting = True
        while accepting or self._queue:
            if not self._queue:
                left = flush_at - time.monotonic() if unflushed else math.inf
                self._queue.wait(max(0.0, min(LOOK_SECONDS, left)))
            accepting = self._queue.accepting
            if self._queue:
                messages = self._queue.take()
                if messages and messages[0][0] is BEGINNING and self._files.is_full:
                    self._files.finish()
                    self._count(unflushed)
                    unflushed = 0
                    self._files.begin_next()
                if not unflushed:
                    flush_at = time.monotonic() + FLUSH_SECONDS
                self._queue.count_taken(len(messages))
                for channel, message, time_ns in messages:
                    self._rest()
                    unflushed += self._write(channel, time_ns, message)
            if unflushed and time.monotonic() >= flush_at:
                self._flush(unflushed)
                unflushed, flush_at = 0, math.inf
        self._flush(unflushed)

    def _rest(self) -> None:
        """Wait for the caller's next entry while it works: two threads that want the interpreter hold each other up."""
        moment = self.rest_from
        if len(self._queue) > FAR_BEHIND:
            return
        if moment != self._rested and time.monotonic() >= moment:
            self._queue.rest(REST_SECONDS)
            self._rested = moment

    def _flush(self, unflushed: int) -> None:
        """Hand everything to the kernel; what was not is in the file from here on."""
        self._files.flush()
        self._count(unflushed)

    def _count(self, written: int) -> None:
        with self._lock:
            self._written += written

    def _write(self, channel: Channel[Any], log_time_ns: int, message: BaseModel | Callable[[], BaseModel]) -> bool:
        try:
            made = message if isinstance(message, BaseModel) else message()
            data = made.model_dump_json().encode()
        except ValueError:  # a text that is no Unicode, say: losing this message must not cost the others
            with self._lock:
                self._unwritable += 1
            return False
        self._files.write(channel.topic, log_time_ns, data)
        return True

    def _end(self, reason: str) -> None:
        with self._lock:
            self._queue.accepting = False
            self._error = self._error or f"{self.path}: the log ended after {self._written} messages: {reason}"


def _single(channel: Channel[Any], message: BaseModel | Callable[[], BaseModel], time_ns: int) -> list[Message]:
    return [(channel, message, time_ns)]
