"""Thinning of an idle stretch in the log: a tenth of a second each minute, and all that surrounds an event.

Replay needs every cycle's inputs from a state on, so cycles are left out between two samples, and each sample begins
with a state, which takes as much room as thirty cycles. The last two seconds are held back, and written in full when
something happens after all.
"""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar

from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleRecord
from tendond.schemas.requests import ControlAction

IDLE_SECONDS = 10.0
"""Time without an event after which an idle stretch is thinned [s]."""

HELD_SECONDS = 2.0
"""Time of cycles that are held back, to log what led to an event [s]; a killed process loses them."""

SAMPLE_SECONDS = 0.1
IDLE_MODES = (Mode.STARTING, Mode.IDLE, Mode.FAULT)

T = TypeVar("T")


class Kept(NamedTuple, Generic[T]):
    """A cycle that goes into the log.

    Attributes:
        record: the cycle's record. more: whatever else the caller has of the cycle.
        left_out: cycles before it that are not in the log, since the one before in it.
        held: it was held back.
    """

    record: CycleRecord
    more: T
    left_out: int
    held: bool


@dataclass
class Thinning(Generic[T]):
    """Choose the cycles.

    Args:
        period: period of the cycle [s].
        idle_period: time from sample to sample [s]; 0: nothing is left out.
    """

    period: float
    idle_period: float

    def __post_init__(self) -> None:
        self._idle_ticks = round(IDLE_SECONDS / self.period)
        self._held_ticks = round(HELD_SECONDS / self.period)
        self._sample_ticks = max(1, round(SAMPLE_SECONDS / self.period))
        self._every = max(self._sample_ticks, round(self.idle_period / self.period))
        self._held: deque[tuple[CycleRecord, T]] = deque()
        self._left_out = 0
        self._last: tuple[object, ...] = ()
        self._event_tick: int | None = None

    @property
    def asleep(self) -> bool:
        """True if cycles are held back."""
        return bool(self._held)

    def take(self, record: CycleRecord, more: T) -> Iterator[Kept[T]]:
        """Take the next cycle; the ones that go into the log now, in order."""
        if self._is_event(record) or self._event_tick is None:
            self._event_tick = record.tick
        if self.idle_period <= 0.0 or record.tick - self._event_tick <= self._idle_ticks:
            yield from self.flush()
            yield self._kept(record, more, held=False)
            return
        self._held.append((record, more))
        if len(self._held) > self._held_ticks:
            oldest = self._held.popleft()
            if oldest[0].tick % self._every < self._sample_ticks:
                yield self._kept(*oldest, held=True)
            else:
                self._left_out += 1

    def flush(self) -> Iterator[Kept[T]]:
        """Give out the ones that are held back."""
        while self._held:
            yield self._kept(*self._held.popleft(), held=True)

    def _kept(self, record: CycleRecord, more: T, *, held: bool) -> Kept[T]:
        left_out, self._left_out = self._left_out, 0
        return Kept(record, more, left_out, held)

    def _is_event(self, record: CycleRecord) -> bool:
        """True if there is more to this cycle than that time passes."""
        state = record.inputs.tendon_state
        now = (record.mode, record.reason, record.law, record.reference.target)
        fault = self._last[-1] if state is None and self._last else "" if state is None else state.fault
        before, self._last = self._last, (*now, fault)
        moves = record.mode not in IDLE_MODES or record.command.armed or any(record.command.tension)
        return self._last != before or moves or record.inputs.request not in (None, ControlAction.STATUS)
