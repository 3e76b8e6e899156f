"""The clock of a log that is played: it runs, stands still, jumps, and runs at another speed, as a viewer asks."""

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

Clock = Callable[[], float]


@dataclass(frozen=True)
class Request:
    """What a viewer asks for.

    Attributes:
        play: true to run, false to stand still.
        speed: of the log's time, relative to real time.
        seek_ns: time to jump to [ns]; none to go on.
    """

    play: bool
    speed: float
    seek_ns: int | None = None


@dataclass(frozen=True)
class State:
    """State of the playback: whether it runs, whether it is at the end, the log's time [ns], and the speed."""

    playing: bool
    ended: bool
    now_ns: int
    speed: float


class Playback:
    """The clock, for one thread that sends messages and others that make requests.

    Args:
        start_ns, end_ns: times of the first and the last message [ns].
        clock: monotonic time [s].

    Attributes:
        controlled: true once a viewer has asked for anything.
    """

    def __init__(self, start_ns: int, end_ns: int, clock: Clock = time.monotonic) -> None:
        self.start_ns, self.end_ns = start_ns, end_ns
        self.controlled = False
        self._clock = clock
        self._changed = threading.Condition()
        self._playing, self._ended, self._speed = True, False, 1.0
        self._seek_ns: int | None = start_ns
        self._set(start_ns)

    def ask(self, request: Request) -> State:
        """Carry out a request; return the state after it. A speed that is none leaves the present one.

        To play on at the end is to begin again.
        """
        with self._changed:
            self.controlled = True
            seek_ns = request.seek_ns
            if seek_ns is None and request.play and self._ended:
                seek_ns = self.start_ns
            self._set(self._now() if seek_ns is None else min(max(seek_ns, self.start_ns), self.end_ns))
            if seek_ns is not None:
                self._seek_ns, self._ended = self._anchor_ns, False
            self._playing = request.play
            if math.isfinite(request.speed) and request.speed > 0.0:
                self._speed = request.speed
            self._changed.notify_all()
            return self._state()

    def state(self) -> State:
        """Return the state."""
        with self._changed:
            return self._state()

    def wait_until(self, time_ns: int) -> bool:
        """Wait until it is `time_ns` in the log; false as soon as a jump was asked for.

        Only the thread that sends messages may call this and those below.
        """
        with self._changed:
            while self._seek_ns is None:
                ahead_ns = time_ns - self._now()
                if ahead_ns <= 0:
                    return True
                self._changed.wait(ahead_ns / 1e9 / self._speed if self._playing else None)
            return False

    def end(self) -> State:
        """Stand at the end of the log, unless a jump was asked for; return the state."""
        with self._changed:
            if self._seek_ns is None:
                self._set(self.end_ns)
                self._playing, self._ended = False, True
            return self._state()

    def wait_for_jump(self) -> None:
        """Wait until a jump is asked for."""
        with self._changed:
            while self._seek_ns is None:
                self._changed.wait()

    def take_jump(self) -> int:
        """Return the time to go on from [ns], which was asked for; again the start where nothing was."""
        with self._changed:
            if self._seek_ns is None:
                self._set(self.start_ns)
            self._seek_ns = None
            self._set(self._anchor_ns)
            return self._anchor_ns

    def _state(self) -> State:
        return State(self._playing, self._ended, self._now(), self._speed)

    def _now(self) -> int:
        runs = self._playing and self._seek_ns is None  # a jump takes no time of the log
        passed = (self._clock() - self._anchor) * self._speed if runs else 0.0
        return min(self._anchor_ns + round(1e9 * passed), self.end_ns)

    def _set(self, now_ns: int) -> None:
        self._anchor, self._anchor_ns = self._clock(), now_ns
