"""Frames in order: blocks of one frame put together, gaps counted, late frames dropped, a restart noticed. Pure."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

from tendond.drivers.vicon.geometry import Placement

LATE_FRAMES = 20
"""Up to so many frames back a packet is late; further back, Tracker has been restarted."""


@dataclass(frozen=True)
class Frame:
    """What was seen at one instant: placements by name; none for an object that was announced but hidden."""

    number: int
    objects: Mapping[str, Placement | None]
    stamp_ns: int


@dataclass
class Sequencer:
    """Blocks in, frames out. A frame is given out as soon as all wanted objects are in it, else when the next begins.

    Attributes:
        wanted: names of objects.
        counts: of what was odd, by name.
    """

    wanted: frozenset[str]
    counts: Counter[str] = field(default_factory=Counter)
    _newest: int | None = None
    _pending: Frame | None = None

    def add(self, block: Frame) -> list[Frame]:
        """A block; the frames that it completes, oldest first."""
        if self._newest is None or block.number > self._newest:
            gap = 0 if self._newest is None else block.number - self._newest - 1
            if gap:
                self.counts["frames lost"] += gap
        elif block.number == self._newest:
            if self._pending is None:
                if self.wanted & block.objects.keys():
                    self.counts["duplicate"] += 1
                return []
            merged = {**self._pending.objects, **block.objects}
            return self._take(Frame(block.number, merged, self._pending.stamp_ns))
        elif self._newest - block.number < LATE_FRAMES:
            self.counts["late"] += 1
            return []
        else:
            self.counts["restarts"] += 1
        before = [] if self._pending is None else [self._pending]
        self._newest = block.number
        return before + self._take(block)

    def _take(self, frame: Frame) -> list[Frame]:
        complete = self.wanted <= frame.objects.keys()
        self._pending = None if complete else frame
        return [frame] if complete else []
