"""Emulated CiA 402 drives: SDO server, PDOs by their mapping, SYNC, heartbeats, the state machine, a motor.

Written from CiA 301 and CiA 402-2, not from the driver or its library, so that a wrong mapping, size or order shows.
"""

import struct
from collections.abc import Callable

INITIAL = {
    (0x1000, 0): ("I", 0x00020192, False),
    (0x1016, 1): ("I", 0, True),
    (0x1017, 0): ("H", 0, True),
    (0x1029, 1): ("B", 0, True),
    (0x6007, 0): ("h", 1, True),
    (0x6040, 0): ("H", 0, True),
    (0x6041, 0): ("H", 0x0040, False),
    (0x605A, 0): ("h", 2, True),
    (0x605E, 0): ("h", 2, True),
    (0x6060, 0): ("b", 0, True),
    (0x6061, 0): ("b", 0, False),
    (0x6064, 0): ("i", 0, False),
    (0x6065, 0): ("I", 0xFFFFFFFF, True),
    (0x6066, 0): ("H", 0, True),
    (0x6072, 0): ("H", 3000, True),
    (0x6073, 0): ("H", 3000, True),
    (0x6077, 0): ("h", 0, False),
    (0x607A, 0): ("i", 0, True),
    (0x60C2, 1): ("B", 1, True),
    (0x60C2, 2): ("b", -3, True),
    (0x6502, 0): ("I", 0x80, False),
}
"""Format, value after power-up and writability of the objects."""

PDOS = ((0x1400, 0x1600, 0x200), (0x1800, 0x1A00, 0x180))
"""Communication and mapping parameter and default COB-ID of RPDO 1 and TPDO 1."""

NO_OBJECT, NO_SUBINDEX, READ_ONLY, WRONG_LENGTH, NOT_NOW = 0x06020000, 0x06090011, 0x06010002, 0x06070010, 0x08000022
INVALID = 1 << 31
PRE_OPERATIONAL, OPERATIONAL, STOPPED = 0x7F, 0x05, 0x04
DISABLED, READY, ON, ENABLED, QUICK, FAULT = 0x40, 0x21, 0x23, 0x27, 0x07, 0x08
"""States, as their bits in the statusword."""

Frames = list[tuple[int, bytes]]


class EmulatedDrive:
    """One drive; time is what `advance` is given.

    Args:
        node: node id.
        speed: largest speed of the motor [counts/s].

    Attributes:
        position: of the motor [counts].
        rest: position to which its tendon pulls it when it has no torque; none: it stays.
        load: torque that its tendon needs at a position [1/1000 of the rated torque].
        silent: it neither hears nor sends anything.
        stuck: it does not move.
        behind: it reports a following error.
        state: bits of the statusword.
    """

    def __init__(self, node: int, speed: float = 1e6) -> None:
        self.node, self.speed, self.position = node, speed, 0.0
        self.rest: float | None = None
        self.load: Callable[[float], float] = lambda position: 0.0
        self.silent = self.stuck = self.behind = False
        self._power_up()

    def _power_up(self) -> None:
        self._objects = dict(INITIAL)
        for communication, mapping, cob_id in PDOS:
            self._objects[communication, 1] = ("I", INVALID | cob_id + self.node, True)
            self._objects[communication, 2] = ("B", 255, True)
            self._objects[mapping, 0] = ("B", 0, True)
            for sub in range(1, 9):
                self._objects[mapping, sub] = ("I", 0, True)
        self.nmt, self.state = PRE_OPERATIONAL, DISABLED
        self._pending: bytes | None = None
        self._word = 0
        self._unheard: float | None = None
        self._behind = self._unsent = 0.0
        self.frames: Frames = [(0x700 + self.node, b"\0")]

    def reboot(self) -> None:
        """Switch the power off and on; it counts its turns without power."""
        self._power_up()

    @property
    def powered(self) -> bool:
        """The motor has torque."""
        return self.state in (ENABLED, QUICK)

    def value(self, index: int, subindex: int = 0) -> int:
        """Return the value of an object."""
        return self._objects[index, subindex][1]

    def put(self, index: int, subindex: int, value: int) -> None:
        """Set an object, whoever may write it."""
        kind, _, writable = self._objects[index, subindex]
        self._objects[index, subindex] = (kind, value, writable)

    def remove(self, index: int, subindex: int = 0) -> None:
        """Remove an object, as of a drive that does not have it."""
        del self._objects[index, subindex]

    def fail(self, code: int) -> None:
        """Enter the state fault, without torque, and send an emergency."""
        self.state = FAULT
        self.frames.append((0x80 + self.node, struct.pack("<HB5x", code, 1)))

    def receive(self, cob_id: int, data: bytes) -> None:
        """Handle a frame; replies are in `frames`."""
        if self.silent:
            return
        if cob_id == 0x600 + self.node and len(data) == 8 and self.nmt != STOPPED:
            self.frames.append((0x580 + self.node, self._sdo(data)))
        elif cob_id == 0 and len(data) == 2 and data[1] in (0, self.node):
            if data[0] in (0x81, 0x82):
                self._power_up()
            self.nmt = {1: OPERATIONAL, 2: STOPPED, 0x80: PRE_OPERATIONAL}.get(data[0], self.nmt)
        elif cob_id == 0x700 + (self.value(0x1016, 1) >> 16 & 0x7F) and self.value(0x1016, 1) & 0xFFFF:
            self._unheard = 0.0
        elif self.nmt == OPERATIONAL and cob_id == self.value(0x1400, 1):
            self._pending = data
        elif self.nmt == OPERATIONAL and cob_id == 0x80:
            self._sync()

    def _sdo(self, data: bytes) -> bytes:
        """Reply to an expedited transfer."""
        command, index, sub = struct.unpack_from("<BHB", data)
        self._measure()
        try:
            if command == 0x40:
                kind = self._find(index, sub)[0]
                value = struct.pack("<" + kind, self.value(index, sub))
                return struct.pack("<BHB", 0x43 | (4 - len(value)) << 2, index, sub) + value.ljust(4, b"\0")
            if command & 0xE3 == 0x23:
                self._write(index, sub, data[4 : 8 - (command >> 2 & 3)])
                return struct.pack("<BHB4x", 0x60, index, sub)
            raise _AbortError(0x05040001)
        except _AbortError as abort:
            return struct.pack("<BHBI", 0x80, index, sub, abort.code)

    def _find(self, index: int, sub: int) -> tuple[str, int, bool]:
        if (found := self._objects.get((index, sub))) is None:
            raise _AbortError(NO_SUBINDEX if any(one == index for one, _ in self._objects) else NO_OBJECT)
        return found

    def _write(self, index: int, sub: int, data: bytes) -> None:
        kind, _, writable = self._find(index, sub)
        if not writable:
            raise _AbortError(READ_ONLY)
        if len(data) != struct.calcsize("<" + kind):
            raise _AbortError(WRONG_LENGTH)
        for communication, mapping, _ in PDOS:  # a PDO is changed only while it does not exist
            if index == mapping and not self.value(communication, 1) & INVALID:
                raise _AbortError(NOT_NOW)
            if index == mapping and sub and self.value(mapping, 0):
                raise _AbortError(NOT_NOW)
        (value,) = struct.unpack("<" + kind, data)
        self.put(index, sub, value)
        if index == 0x6060:
            self.put(0x6061, 0, value)
        if index == 0x6040:
            self._control(value)

    def _mapped(self, mapping: int) -> list[tuple[int, int]]:
        entries = [self.value(mapping, sub + 1) for sub in range(self.value(mapping, 0))]
        return [(entry >> 16, entry >> 8 & 0xFF) for entry in entries]

    def _sync(self) -> None:
        """Apply the RPDO, send the TPDO."""
        data, self._pending = self._pending, None
        if data is not None and self.value(0x1400, 2) == 1:
            entries = self._mapped(0x1600)
            kinds = "<" + "".join(self._objects[entry][0] for entry in entries)
            for entry, value in zip(entries, struct.unpack(kinds, data), strict=True):
                self.put(*entry, value)
            self._control(self.value(0x6040))
        if self.value(0x1800, 2) == 1 and not self.value(0x1800, 1) & INVALID:
            self._measure()
            entries = self._mapped(0x1A00)
            kinds = "<" + "".join(self._objects[entry][0] for entry in entries)
            self.frames.append((self.value(0x1800, 1) & 0x7FF, struct.pack(kinds, *(self.value(*e) for e in entries))))

    def _measure(self) -> None:
        self.put(0x6041, 0, self.state | (1 << 13 if self.behind else 0))
        self.put(0x6064, 0, round(self.position))
        self.put(0x6077, 0, round(self.load(self.position)) if self.powered else 0)

    def _control(self, word: int) -> None:
        """Follow a controlword: transitions of CiA 402-2."""
        before, self._word = self._word, word
        if self.state == FAULT:
            if word & 0x80 and not before & 0x80:
                self.state = DISABLED
            return
        if not word & 0x02:
            self.state = DISABLED
        elif not word & 0x04:
            self.state = QUICK if self.powered else DISABLED
        elif word & 0x0F == 0x0F and (self.state in (ON, ENABLED) or self._leaves_quick_stop):
            self.state = ENABLED
        elif word & 0x0F == 0x07 and self.state in (READY, ENABLED):
            self.state = ON
        elif word & 0x07 == 0x06 and self.state != QUICK:
            self.state = READY

    @property
    def _leaves_quick_stop(self) -> bool:
        return self.state == QUICK and self.value(0x605A) in (5, 6, 7, 8)

    def advance(self, seconds: float) -> None:
        """Advance the motor, the watchdog, the heartbeat and the following error."""
        self._listen(seconds)
        self._unsent += seconds
        if (period := self.value(0x1017)) and self._unsent >= 1e-3 * period:
            self._unsent = 0.0
            self.frames.append((0x700 + self.node, bytes((self.nmt,))))
        if self.state == QUICK and self.value(0x605A) == 2:
            self.state = DISABLED
        step = self.speed * seconds
        if self.state == ENABLED and not self.stuck and self.value(0x6061) == 8:
            if abs(self.load(self.position)) <= self.value(0x6072):
                self.position += min(max(self.value(0x607A) - self.position, -step), step)
        elif not self.powered and self.rest is not None:
            self.position += min(max(self.rest - self.position, -step), step)
        behind = abs(self.value(0x607A) - self.position) > self.value(0x6065)
        self._behind = self._behind + seconds if behind and self.state == ENABLED else 0.0
        if self._behind > 1e-3 * self.value(0x6066):
            self.fail(0x8611)

    def _listen(self, seconds: float) -> None:
        """Miss the driver's heartbeat: emergency, and what the option codes say."""
        if self._unheard is None:
            return
        self._unheard += seconds
        if self._unheard > 1e-3 * (self.value(0x1016, 1) & 0xFFFF):
            self._unheard = None
            self.frames.append((0x80 + self.node, struct.pack("<HB5x", 0x8130, 0x11)))
            if self.value(0x1029, 1) == 0 and self.nmt == OPERATIONAL:
                self.nmt = PRE_OPERATIONAL
            if self.powered and self.value(0x6007) == 3:
                self.state = QUICK
            elif self.powered and self.value(0x6007):
                self.state = FAULT if self.value(0x6007) == 1 else DISABLED

    def sent(self) -> Frames:
        """Return the frames that it has sent since."""
        frames, self.frames = self.frames, []
        return [] if self.silent else frames


class _AbortError(Exception):
    def __init__(self, code: int) -> None:
        self.code = code
