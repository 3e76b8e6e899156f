"""Frames in order: blocks of one frame put together, gaps counted, late frames dropped, a restart noticed. Pure."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

from tendond.drivers.mocap.geometry import Placement

LATE_FRAMES = 20
"""Largest number of frames by which a packet can be late; beyond, Tracker was restarted."""

FRAMES_PER_SECOND_MAX = 2000
"""Rate of the fastest cameras [1/s]: a larger step of the frame number is a restart, not a gap."""

NUMBERS = 2**32
"""Number of values of Tracker's frame number, of four bytes."""


POLL_SECONDS = 0.2
"""Longest wait for a frame, after which a driver looks at everything else [s]."""

STALE_NS = 100_000_000
"""Waiting time after which a frame is dropped [ns]."""


@dataclass(frozen=True)
class Frame:
    """Objects measured at one instant.

    Attributes:
        number: number of the frame, below `NUMBERS`.
        objects: placements by name; none for an object that was announced, but is hidden or cannot be used.
        stamp_ns: time of arrival, monotonic clock [ns].
        faults: reasons for which one of them cannot be used, by name.
    """

    number: int
    objects: Mapping[str, Placement | None]
    stamp_ns: int
    faults: Mapping[str, str] = field(default_factory=dict)


@dataclass
class Sequencer:
    """Blocks in, frames out. A frame is given out as soon as all wanted objects are in it, else when the next begins.

    Attributes:
        wanted: names of objects.
        counts: number of irregularities, by name.
    """

    wanted: frozenset[str]
    counts: Counter[str] = field(default_factory=Counter)
    _newest: int | None = None
    _newest_ns: int = 0
    _pending: Frame | None = None

    def add(self, block: Frame) -> list[Frame]:
        """Add a block; return the frames that it completes, oldest first."""
        ahead = 1 if self._newest is None else _ahead(block.number, self._newest)
        if ahead == 0:
            if self._pending is None:
                if self.wanted & block.objects.keys():
                    self.counts["duplicate"] += 1
                return []
            merged = {**self._pending.objects, **block.objects}
            faults = {**self._pending.faults, **block.faults}
            return self._take(Frame(block.number, merged, self._pending.stamp_ns, faults))
        if -LATE_FRAMES < ahead < 0:
            self.counts["late"] += 1
            return []
        if 0 < ahead <= LATE_FRAMES + FRAMES_PER_SECOND_MAX * max(0, block.stamp_ns - self._newest_ns) * 1e-9:
            if ahead > 1:
                self.counts["frames lost"] += ahead - 1
        elif self._newest is not None:
            self.counts["restarts"] += 1
        before = [] if self._pending is None else [self._pending]
        self._newest, self._newest_ns = block.number, block.stamp_ns
        return before + self._take(block)

    def _take(self, frame: Frame) -> list[Frame]:
        complete = self.wanted <= frame.objects.keys()
        self._pending = None if complete else frame
        return [frame] if complete else []


def _ahead(number: int, newest: int) -> int:
    """Return by how many frames a number is ahead of another, modulo `NUMBERS`."""
    return (number - newest + NUMBERS // 2) % NUMBERS - NUMBERS // 2
