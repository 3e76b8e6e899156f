"""New servos behind a pseudo-terminal, and the host that asks them."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tendond.drivers.dynamixel.emulator.bus import EmulatedBus
from tendond.drivers.dynamixel.emulator.servo import EmulatedServo
from tests.conformance import manual
from tests.conformance.host import Host, Status

PATIENCE_SECONDS = 5.0


@dataclass
class ServoBench:
    """ServoGroup 1 and 2 as they come from the factory, but for the second's id.

    Attributes:
        bus: of the emulated servos, to turn their shafts and heat them.
        host: that asks them.
    """

    bus: EmulatedBus
    host: Host

    @property
    def first(self) -> EmulatedServo:
        """Return the emulated servo 1."""
        return self.bus.servos[0]

    def get(self, name: str, identifier: int = 1, *, signed: bool = False) -> int:
        """Return a register's value by its name in the manual."""
        row = ROWS[name]
        return self.host.value(identifier, row.address, row.size, signed=signed)

    def put(self, name: str, value: int, identifier: int = 1) -> int:
        """Write a register by its name; the error."""
        row = ROWS[name]
        return self.host.write(identifier, row.address, row.size, value)

    def whisper(self, name: str, value: int, identifier: int = 1) -> list[Status]:
        """Write as `put` does, where no reply may come."""
        row = ROWS[name]
        return list(self.host.quietly(identifier, row.address, row.size, value))

    def until(self, happens: Callable[[], bool]) -> bool:
        """Return whether it happens in a while."""
        deadline = time.monotonic() + PATIENCE_SECONDS
        while not happens():
            if time.monotonic() > deadline:
                return False
        return True

    def extended(self) -> None:
        """Extended position mode, torque on."""
        assert self.put("Operating Mode", 4) == 0
        assert self.put("Torque Enable", 1) == 0


ROWS = {row.name: row for row in manual.rows()}


@contextmanager
def bench(folder: Path) -> Iterator[ServoBench]:
    """Fresh servos, away when it is done; the emulator must not have stumbled."""
    servos = [EmulatedServo(1, 57600, position=1000), EmulatedServo(2, 57600, position=2079)]
    with EmulatedBus(folder / "ttyServos", servos) as bus:
        host = Host(str(folder / "ttyServos"))
        try:
            yield ServoBench(bus, host)
        finally:
            host.close()
        assert bus.alive
        assert not bus.errors, bus.errors
