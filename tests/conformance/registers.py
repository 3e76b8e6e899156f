"""The control table, register by register: address, size, initial value, range, access."""

from collections.abc import Iterator

from tests.conformance import manual
from tests.conformance.bench import ServoBench
from tests.conformance.manual import Row

REFUSED = {manual.RANGE_ERROR, manual.LIMIT_ERROR}
SPECIAL = {"ID", "Baud Rate", "Drive Mode", "Operating Mode", "Protocol Type", "Status Return Level", "Torque Enable"}
"""Written by rules of their own: a write changes how the servo is heard or what it accepts."""

OFF_BELOW = {"Secondary(Shadow) ID": 255, "Bus Watchdog": 127}
"""Highest value that is accepted, where it is beyond the table's range: 253 to 255 mean none, and 0 means off."""


def check(bench: ServoBench, row: Row) -> Iterator[str]:
    """Yield the differences between a register and its row."""
    host = bench.host
    reply = host.read(1, row.address, row.size)
    if reply.error or len(reply.data) != row.size:
        yield f"read: error {reply.error}, {len(reply.data)} bytes"
        return
    value = int.from_bytes(reply.data, "little", signed=row.low is not None and row.low < 0)
    if row.initial is not None and value != row.initial:
        yield f"initial value {value}"
    if not row.writable:
        if (error := host.write(1, row.address, row.size, 0)) != manual.ACCESS_ERROR:
            yield f"write: error {error}"
        return
    if row.size > 1 and (error := host.write(1, row.address, row.size - 1, 0)) != manual.LENGTH_ERROR:
        yield f"short write: error {error}"
    if row.eeprom:
        yield from _lock(bench, row, value)
    yield from _range(bench, row)


def _range(bench: ServoBench, row: Row) -> Iterator[str]:
    host, high = bench.host, OFF_BELOW.get(row.name, row.high)
    if row.low is None or high is None:
        return
    if row.name not in SPECIAL:
        for edge in (row.low, high):
            if error := host.write(1, row.address, row.size, edge):
                yield f"write of {edge}: error {error}"
            elif (now := host.value(1, row.address, row.size, signed=row.low < 0)) != edge:
                yield f"write of {edge}: holds {now}"
    largest = 2 ** (8 * row.size) - 1
    for beyond in (row.low - 1, high + 1):
        if row.low <= 0 and beyond == -1 and row.name != "Bus Watchdog":
            continue  # all bits set: a large number
        if row.name == "Bus Watchdog" and beyond == 0:
            continue
        if beyond <= largest and (error := host.write(1, row.address, row.size, beyond)) not in REFUSED:
            yield f"write of {beyond}: error {error}"
    if row.low >= 0 and high < largest and (error := host.write(1, row.address, row.size, largest)) not in REFUSED:
        yield f"write of {largest}: error {error}"


def _lock(bench: ServoBench, row: Row, value: int) -> Iterator[str]:
    """EEPROM cannot be written while the torque is on."""
    bench.put("Torque Enable", 1)
    if (error := bench.host.write(1, row.address, row.size, value)) != manual.ACCESS_ERROR:
        yield f"write with torque on: error {error}"
    bench.put("Torque Enable", 0)


def undefined(bench: ServoBench, address: int) -> Iterator[str]:
    """Yield the differences at an address without a register."""
    if (error := bench.host.read(1, address, 1).error) != manual.ACCESS_ERROR:
        yield f"read: error {error}"
    if (error := bench.host.write(1, address, 1, 0)) != manual.ACCESS_ERROR:
        yield f"write: error {error}"
