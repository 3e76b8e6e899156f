"""Objects of a drive that the driver uses, with the names of CiA 301 and CiA 402-2 (IEC 61800-7-201)."""

import struct
from dataclasses import dataclass


@dataclass(frozen=True)
class Entry:
    """Entry of the object dictionary; `kind` is its format as of `struct`, little-endian."""

    name: str
    index: int
    subindex: int
    kind: str

    @property
    def size(self) -> int:
        """Size [bytes]."""
        return struct.calcsize("<" + self.kind)

    @property
    def mapping(self) -> int:
        """Mapping of the entry in a PDO: index, subindex, length in bits."""
        return self.index << 16 | self.subindex << 8 | 8 * self.size

    def pack(self, value: int) -> bytes:
        """Return the bytes of a value."""
        return struct.pack("<" + self.kind, value)

    def unpack(self, data: bytes) -> int:
        """Return the value of bytes; missing ones, of a drive that sends a shorter type, are zeros."""
        return int(struct.unpack("<" + self.kind, data[: self.size].ljust(self.size, b"\0"))[0])

    def __str__(self) -> str:
        sub = f":{self.subindex}" if self.subindex else ""
        return f"{self.name} (0x{self.index:04X}{sub})"


DEVICE_TYPE = Entry("Device type", 0x1000, 0, "I")
CONSUMER_HEARTBEAT = Entry("Consumer heartbeat time", 0x1016, 1, "I")
ERROR_BEHAVIOUR = Entry("Error behaviour", 0x1029, 1, "B")
RPDO_COB_ID = Entry("RPDO communication parameter", 0x1400, 1, "I")
RPDO_TYPE = Entry("RPDO communication parameter", 0x1400, 2, "B")
RPDO_COUNT = Entry("RPDO mapping parameter", 0x1600, 0, "B")
TPDO_COB_ID = Entry("TPDO communication parameter", 0x1800, 1, "I")
TPDO_TYPE = Entry("TPDO communication parameter", 0x1800, 2, "B")
TPDO_COUNT = Entry("TPDO mapping parameter", 0x1A00, 0, "B")
ABORT_CONNECTION = Entry("Abort connection option code", 0x6007, 0, "h")
CONTROLWORD = Entry("Controlword", 0x6040, 0, "H")
STATUSWORD = Entry("Statusword", 0x6041, 0, "H")
QUICK_STOP_OPTION = Entry("Quick stop option code", 0x605A, 0, "h")
FAULT_REACTION = Entry("Fault reaction option code", 0x605E, 0, "h")
MODE = Entry("Modes of operation", 0x6060, 0, "b")
MODE_DISPLAY = Entry("Modes of operation display", 0x6061, 0, "b")
POSITION = Entry("Position actual value", 0x6064, 0, "i")
FOLLOWING_WINDOW = Entry("Following error window", 0x6065, 0, "I")
FOLLOWING_TIME = Entry("Following error time out", 0x6066, 0, "H")
MAX_TORQUE = Entry("Max torque", 0x6072, 0, "H")
MAX_CURRENT = Entry("Max current", 0x6073, 0, "H")
TORQUE = Entry("Torque actual value", 0x6077, 0, "h")
TARGET = Entry("Target position", 0x607A, 0, "i")
PERIOD_VALUE = Entry("Interpolation time period", 0x60C2, 1, "B")
PERIOD_INDEX = Entry("Interpolation time period", 0x60C2, 2, "b")
SUPPORTED_MODES = Entry("Supported drive modes", 0x6502, 0, "I")

SENT = (CONTROLWORD, TARGET)
"""Contents of RPDO 1."""

RECEIVED = (STATUSWORD, POSITION, TORQUE)
"""Contents of TPDO 1."""

OPTIONAL = frozenset({ERROR_BEHAVIOUR, FOLLOWING_TIME, FAULT_REACTION, PERIOD_VALUE, PERIOD_INDEX})
"""Objects without which the driver works: the rest of what a drive does without them is the same or is safer."""

PROFILE = 402
"""Device profile number, in the lower half of Device type."""

CYCLIC_POSITION = 8
"""Mode cyclic synchronous position; its bit in Supported drive modes is the one before."""

INVALID = 1 << 31
"""Bit of a PDO's COB-ID: it does not exist, so that its mapping may be changed."""

KEEP_NMT_STATE = 1
"""Error behaviour: a lost heartbeat leaves the drive operational, so that it still reports."""

ABORT_QUICK_STOP = 3
"""Abort connection option code: quick stop command."""

STOP_AND_DISABLE, STOP_AND_HOLD = 2, 6
"""Quick stop option codes: slow down on the quick stop ramp, then without torque, or stay in quick stop active."""

REACT_AND_DISABLE = 2
"""Fault reaction option code: slow down on the quick stop ramp; without torque at its end."""

ERRORS = {
    0x2310: "continuous over current",
    0x3210: "DC link over-voltage",
    0x3220: "DC link under-voltage",
    0x4210: "excess temperature of the device",
    0x4310: "excess temperature of the drive",
    0x7300: "sensor",
    0x8120: "CAN in error passive mode",
    0x8130: "heartbeat error: it heard no driver",
    0x8140: "recovered from bus off",
    0x8611: "following error",
}
"""Emergency error codes that are common, of CiA 301 and CiA 402-2."""


def error_name(code: int) -> str:
    """Return an emergency error code in words."""
    return f"0x{code:04X}" + (f", {ERRORS[code]}" if code in ERRORS else ", see the drive's manual")
