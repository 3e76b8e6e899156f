"""The manual's tables, typed from it and not from the driver's: ROBOTIS e-Manual, XL430-W250-T and Protocol 2.0."""

from dataclasses import dataclass

CONTROL_TABLE = """
  0 | 2 | Model Number           | R  | 1060 | -
  2 | 4 | Model Information      | R  | -    | -
  6 | 1 | Firmware Version       | R  | -    | -
  7 | 1 | ID                     | RW | 1    | 0 ~ 252
  8 | 1 | Baud Rate              | RW | 1    | 0 ~ 7
  9 | 1 | Return Delay Time      | RW | 250  | 0 ~ 254
 10 | 1 | Drive Mode             | RW | 0    | 0 ~ 13
 11 | 1 | Operating Mode         | RW | 3    | 0 ~ 16
 12 | 1 | Secondary(Shadow) ID   | RW | 255  | 0 ~ 252
 13 | 1 | Protocol Type          | RW | 2    | 1 ~ 2
 20 | 4 | Homing Offset          | RW | 0    | -1044479 ~ 1044479
 24 | 4 | Moving Threshold       | RW | 10   | 0 ~ 1023
 31 | 1 | Temperature Limit      | RW | 72   | 0 ~ 100
 32 | 2 | Max Voltage Limit      | RW | 140  | 60 ~ 140
 34 | 2 | Min Voltage Limit      | RW | 60   | 60 ~ 140
 36 | 2 | PWM Limit              | RW | 885  | 0 ~ 885
 44 | 4 | Velocity Limit         | RW | 265  | 0 ~ 1023
 48 | 4 | Max Position Limit     | RW | 4095 | 0 ~ 4095
 52 | 4 | Min Position Limit     | RW | 0    | 0 ~ 4095
 60 | 1 | Startup Configuration  | RW | 0    | 0 ~ 3
 63 | 1 | Shutdown               | RW | 52   | -
 64 | 1 | Torque Enable          | RW | 0    | 0 ~ 1
 65 | 1 | LED                    | RW | 0    | 0 ~ 1
 68 | 1 | Status Return Level    | RW | 2    | 0 ~ 2
 69 | 1 | Registered Instruction | R  | 0    | 0 ~ 1
 70 | 1 | Hardware Error Status  | R  | 0    | -
 76 | 2 | Velocity I Gain        | RW | 1000 | 0 ~ 16383
 78 | 2 | Velocity P Gain        | RW | 100  | 0 ~ 16383
 80 | 2 | Position D Gain        | RW | 4000 | 0 ~ 16383
 82 | 2 | Position I Gain        | RW | 0    | 0 ~ 16383
 84 | 2 | Position P Gain        | RW | 640  | 0 ~ 16383
 88 | 2 | Feedforward 2nd Gain   | RW | 0    | 0 ~ 16383
 90 | 2 | Feedforward 1st Gain   | RW | 0    | 0 ~ 16383
 98 | 1 | Bus Watchdog           | RW | 0    | 1 ~ 127
100 | 2 | Goal PWM               | RW | -    | -885 ~ 885
104 | 4 | Goal Velocity          | RW | -    | -265 ~ 265
108 | 4 | Profile Acceleration   | RW | 0    | 0 ~ 32767
112 | 4 | Profile Velocity       | RW | 0    | 0 ~ 32767
116 | 4 | Goal Position          | RW | -    | 0 ~ 4095
120 | 2 | Realtime Tick          | R  | -    | 0 ~ 32767
122 | 1 | Moving                 | R  | 0    | 0 ~ 1
123 | 1 | Moving Status          | R  | -    | -
124 | 2 | Present PWM            | R  | -    | -
126 | 2 | Present Load           | R  | -    | -1000 ~ 1000
128 | 4 | Present Velocity       | R  | -    | -
132 | 4 | Present Position       | R  | -    | -
136 | 4 | Velocity Trajectory    | R  | -    | -
140 | 4 | Position Trajectory    | R  | -    | -
144 | 2 | Present Input Voltage  | R  | -    | -
146 | 1 | Present Temperature    | R  | -    | -
147 | 1 | Backup Ready           | R  | -    | 0 ~ 1
"""
"""Address, size, name, access, initial value, range; '-' where the manual has none. Moving Status is 0 at first in the
manual, where its bit In-Position says that a servo at rest has arrived: left open here. The ranges of the goals are the
factory's limits, in Position Control Mode."""

INDIRECT = ((1, 28, 168, 224), (29, 56, 578, 634))
"""First and last number, address of the first Indirect Address [2 bytes, 64 ~ 661], of the first Indirect Data."""

EEPROM_END = 64
TABLE_END = 662

UNDEFINED = (14, 19, 28, 37, 40, 56, 61, 66, 71, 86, 92, 102, 148, 252, 662)
"""Some addresses at which nothing is."""

BAUD_RATES = {0: 9600, 1: 57600, 2: 115200, 3: 1000000, 4: 2000000, 5: 3000000, 6: 4000000, 7: 4500000}

OPERATING_MODES = (1, 3, 4, 16)
NO_MODES = (0, 2, 5, 6, 15)

SHUTDOWN_BITS = (0, 2, 3, 4, 5)
"""Input voltage, overheating, encoder, electrical shock, overload."""

PING, READ, WRITE, REG_WRITE, ACTION = 0x01, 0x02, 0x03, 0x04, 0x05
FACTORY_RESET, REBOOT, CLEAR, STATUS = 0x06, 0x08, 0x10, 0x55
SYNC_READ, SYNC_WRITE, FAST_SYNC_READ, BULK_READ, BULK_WRITE = 0x82, 0x83, 0x8A, 0x92, 0x93
BROADCAST = 0xFE

RESULT_FAIL, INSTRUCTION_ERROR, CRC_ERROR, RANGE_ERROR, LENGTH_ERROR, LIMIT_ERROR, ACCESS_ERROR = range(1, 8)
ALERT = 0x80

CLEAR_TURNS = bytes((0x01, 0x44, 0x58, 0x4C, 0x22))

EXAMPLES = (
    ("ping of servo 1", "FF FF FD 00 01 03 00 01 19 4E"),
    ("ping of all", "FF FF FD 00 FE 03 00 01 31 42"),
    ("read of Present Position", "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15"),
    ("write of 512 to Goal Position", "FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89"),
    ("action", "FF FF FD 00 01 03 00 05 02 CE"),
    ("factory reset", "FF FF FD 00 01 04 00 06 01 A1 E6"),
    ("reboot", "FF FF FD 00 01 03 00 08 2F 4E"),
    ("clear", "FF FF FD 00 01 08 00 10 01 44 58 4C 22 B1 DC"),
    ("sync read", "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA"),
    ("bulk read", "FF FF FD 00 FE 0D 00 92 01 90 00 02 00 02 92 00 01 00 1A 05"),
)
"""Packets as the manual prints them."""


@dataclass(frozen=True)
class Row:
    """A row of the control table; `initial` or the range may be open."""

    address: int
    size: int
    name: str
    writable: bool
    initial: int | None
    low: int | None
    high: int | None

    @property
    def eeprom(self) -> bool:
        """True in the area that is kept without power."""
        return self.address < EEPROM_END


def rows() -> list[Row]:
    """Return the control table, Indirect Addresses and Data included."""
    table = []
    for line in CONTROL_TABLE.strip().splitlines():
        address, size, name, access, initial, bounds = (cell.strip() for cell in line.split("|"))
        low, _, high = bounds.partition(" ~ ")
        table.append(
            Row(
                int(address),
                int(size),
                name,
                access == "RW",
                None if initial == "-" else int(initial),
                None if low == "-" else int(low),
                None if not high else int(high),
            )
        )
    for first, last, addresses, data in INDIRECT:
        for n in range(last - first + 1):
            table.append(Row(addresses + 2 * n, 2, f"Indirect Address {first + n}", True, data + n, 64, 661))
            table.append(Row(data + n, 1, f"Indirect Data {first + n}", True, 0, 0, 255))
    return sorted(table, key=lambda row: row.address)
