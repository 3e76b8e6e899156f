"""Emulated servos on a pseudo-terminal, set up for a rig."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tendond.drivers.dynamixel import table
from tendond.drivers.dynamixel.emulator.bus import EmulatedBus
from tendond.drivers.dynamixel.emulator.servo import EmulatedServo

BAUDRATE = 1_000_000
ANSWER_SECONDS = 0.1
"""Generous: the emulator is a thread of a busy machine."""


@contextmanager
def emulated(folder: Path, count: int = 4, *, position: int = 2048, ready: bool = True) -> Iterator[EmulatedBus]:
    """A bus with servos 1 to `count`, in extended position mode when `ready`."""
    servos = [EmulatedServo(i + 1, BAUDRATE if ready else 57600, position) for i in range(count)]
    if ready:
        for servo in servos:
            servo.write(table.OPERATING_MODE.address, bytes([table.EXTENDED_POSITION]))
    with EmulatedBus(folder / "ttyUSB0", servos) as bus:
        yield bus
