"""Times of frames by their numbers: cameras are regular, their packets come as late as a computer was busy."""

from tendond.drivers.vicon.frames import FRAMES_PER_SECOND_MAX, NUMBERS

GAIN = 0.03
"""Part of a delay by which the frames' times follow later packets: a network that has become slower is followed in a
third of a second at 100 Hz, a packet that this computer left waiting by a thirtieth."""

MOST_NS = 30_000_000
"""Largest correction [ns]; beyond, numbers or network are not as they were, and the packet's own time counts."""

SLOWEST = 1.0
"""Longest interval between two frames over which the clock goes on [s]."""


class FrameClock:
    """Delay-locked loop that turns arrival times into times of regular frames, never later than the arrival.

    An earlier packet than expected moves it at once, as no packet comes before its frame; a later one hardly (the
    filter is that of F. Adriaensen, "Using a DLL to filter time", 2005, with a growing memory at the beginning).
    """

    def __init__(self) -> None:
        self._number, self._at, self._interval, self._frames = 0, 0.0, 0.0, 0

    def stamp(self, number: int, arrival_ns: int) -> int:
        """Return the time of a frame [ns]; `arrival_ns`: of its packet, monotonic clock."""
        passed = (number - self._number) % NUMBERS
        since = arrival_ns - self._at
        if self._frames and passed == 0:
            return min(round(self._at), arrival_ns)
        if not self._frames or not 0.0 < since < 1e9 * SLOWEST or passed > SLOWEST * FRAMES_PER_SECOND_MAX:
            return self._restart(number, arrival_ns)
        if self._frames == 1:
            self._interval = since / passed
        late = since - passed * self._interval
        if abs(late) > MOST_NS:
            return self._restart(number, arrival_ns)
        k = float(self._frames)
        gain = max(GAIN, 2.0 * (2.0 * k - 1.0) / (k * (k + 1.0)))
        rate = max(GAIN**2 / (2.0 - GAIN), 6.0 / (k * (k + 1.0)) if k > 1.0 else 0.0)
        self._at += passed * self._interval + late * (1.0 if late < 0.0 else min(gain, 1.0))
        self._interval += min(rate, 1.0) * late / passed
        self._number, self._frames = number, self._frames + 1
        return round(self._at)

    def _restart(self, number: int, arrival_ns: int) -> int:
        self._number, self._at, self._interval, self._frames = number, float(arrival_ns), 0.0, 1
        return arrival_ns
