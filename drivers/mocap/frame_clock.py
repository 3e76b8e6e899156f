"""Times of frames by their numbers: cameras are regular, their packets come as late as a computer was busy."""

from tendond.drivers.mocap.frames import FRAMES_PER_SECOND_MAX, LATE_FRAMES, NUMBERS

GAIN = 0.03
"""Part of a delay by which the frames' times follow later packets: a network that has become slower is followed in a
third of a second at 100 Hz, a packet that this computer left waiting by a thirtieth."""

MOST_NS = 30_000_000
"""Largest correction [ns]: beyond it the packet's own time counts."""

STRIKES = 50
"""Frames in a row beyond it, after which numbers or network are not as they were, and the clock starts anew."""

SLOWEST = 1.0
"""Longest interval between two frames over which the clock goes on [s]."""


class FrameClock:
    """Delay-locked loop that turns arrival times into times of regular frames, never later than the arrival.

    An earlier packet than expected moves it at once, as no packet comes before its frame; a later one hardly (the
    filter is that of F. Adriaensen, "Using a DLL to filter time", 2005, with a growing memory at the beginning).
    """

    def __init__(self) -> None:
        self._number, self._at, self._interval = 0, 0.0, 0.0
        self._frames, self._strikes = 0, 0

    def stamp(self, number: int, arrival_ns: int) -> int:
        """Return the time of a frame [ns]; `arrival_ns`: of its packet, monotonic clock."""
        passed = (number - self._number) % NUMBERS
        since = arrival_ns - self._at
        if self._frames and (passed == 0 or passed > NUMBERS - LATE_FRAMES):  # of this frame, or of an earlier one
            return min(round(self._at - (-passed % NUMBERS) * self._interval), arrival_ns)
        plausible = 0.0 < since < 1e9 * SLOWEST and passed <= SLOWEST * FRAMES_PER_SECOND_MAX
        if not self._frames or not plausible or self._strikes >= STRIKES:
            self._number, self._at, self._frames, self._strikes = number, float(arrival_ns), 1, 0
            return arrival_ns
        if self._frames == 1:
            self._interval = since / passed
        late = since - passed * self._interval
        if abs(late) > MOST_NS:  # a stall, after which packets come at once, and go on as before
            self._number, self._at, self._strikes = number, self._at + passed * self._interval, self._strikes + 1
            return arrival_ns
        self._strikes = 0
        k = float(self._frames)
        gain = max(GAIN, 2.0 * (2.0 * k - 1.0) / (k * (k + 1.0)))
        rate = max(GAIN**2 / (2.0 - GAIN), 6.0 / (k * (k + 1.0)) if k > 1.0 else 0.0)
        self._at += passed * self._interval + late * (1.0 if late < 0.0 else min(gain, 1.0))
        self._interval += min(rate, 1.0) * late / passed
        self._number, self._frames = number, self._frames + 1
        return round(self._at)
