"""Bodies with a new measurement only, where a client hands out old ones again. Pure.

`motioncapture` gives the bodies of VRPN at a rate of its own, whatever came meanwhile, and those of NatNet again after
any other packet. Cameras never measure the same numbers twice to the last bit, so a body whose numbers are those of
before was not measured.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

FROZEN = "without a new measurement"

Numbers = tuple[float, ...]
"""Position and quaternion as they came, shape (7,)."""


@dataclass
class Updates:
    """Tell measurements from repetitions.

    Attributes:
        tip: name of the body whose measurements make frames.
        others: names of the bodies that go with it.
        hold_ns: age beyond which a measurement counts no more [ns].
    """

    tip: str
    others: Collection[str]
    hold_ns: int
    _last: dict[str, tuple[Numbers, int]] = field(default_factory=dict)
    _at_ns: int | None = None

    def take(
        self, bodies: Mapping[str, Numbers], stamp_ns: int
    ) -> tuple[Mapping[str, Numbers | None], Mapping[str, str]] | None:
        """Take what a client gave; return the measured bodies, none for one that was not, and their faults by name.

        Returns none where there is nothing to say: no new measurement of the tip, and its last one is recent.

        Args:
            bodies: numbers by name; a body that is missing was not measured.
            stamp_ns: time, monotonic clock [ns].
        """
        if self._at_ns is None:
            self._at_ns = stamp_ns
        new = set()
        for name in (self.tip, *self.others):
            if name in bodies and (name not in self._last or self._last[name][0] != bodies[name]):
                self._last[name] = bodies[name], stamp_ns
                new.add(name)
        if self.tip not in new and stamp_ns - self._at_ns <= self.hold_ns:
            return None
        self._at_ns = stamp_ns
        measured: dict[str, Numbers | None] = {}
        faults: dict[str, str] = {}
        for name in (self.tip, *self.others):
            numbers, at_ns = self._last.get(name, (None, 0))
            if numbers is None:
                continue  # never there: missing, not occluded
            fresh = name in new or (name != self.tip and stamp_ns - at_ns <= self.hold_ns)
            measured[name] = numbers if fresh else None
            if not fresh:
                faults[name] = FROZEN
        return measured, faults
