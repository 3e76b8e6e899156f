"""Find connected servos, and the causes of missing ones. Nothing is moved or changed."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.adapter import DELAYED_SECONDS, latency_timer, latency_warning
from tendond.drivers.dynamixel.serial.bus import NoReplyError, PortLostError, RefusedError, ServoBus
from tendond.drivers.dynamixel.serial.models import model_of, name_of
from tendond.drivers.dynamixel.serial.ping import PING_SLOT_SECONDS, ping_all
from tendond.schemas.config.servo import BAUD_RATES

PORTS = ("ttyUSB*", "ttyACM*", "serial/by-id/*")

PATIENCE = PING_SLOT_SECONDS * (table.ID.maximum + 1)
"""Silence after a ping to all [s]: each servo replies in its slot, by its id."""

PASSES = 2
"""Number of pings to all at each rate: a reply may be lost."""

PROOF = (table.PRESENT_POSITION, table.PRESENT_INPUT_VOLTAGE, table.REALTIME_TICK)
PATIENT_SECONDS = 0.04
"""Timeout for a servo that has replied [s]: longer than an adapter with its default timer delays it."""

GARBLED = "unintelligible replies"
"""Words of a progress line about replies that are not from a single servo."""

PROOFS = 4
"""Reads of each register that show whether two servos reply at once: their replies to a ping may be equal."""


@dataclass(frozen=True)
class FoundServo:
    """Servo that replied; `doubt` explains why it may be two."""

    port: str
    baudrate: int
    id: int
    model: int
    doubt: str = ""

    def __str__(self) -> str:
        return f"{self.port}: {self.baudrate} bit/s, id {self.id}: {name_of(self.model)}{self.doubt}"


def ports(devices: Path = Path("/dev")) -> list[str]:
    """List the connected serial adapters, each once."""
    found: dict[Path, str] = {}
    for pattern in PORTS:
        for path in sorted(devices.glob(pattern)):
            found.setdefault(path.resolve(), str(path))
    return list(found.values())


def scan(
    names: Sequence[str],
    reply_timeout: float,
    last_id: int = table.ID.maximum,
    baudrates: Sequence[int] = BAUD_RATES,
    progress: Callable[[str], None] = lambda line: None,
    patience: float = PATIENCE,
) -> Iterator[FoundServo]:
    """Ping every id at every rate on every port.

    Args:
        names: names of the ports.
        reply_timeout: reply timeout of [servo] [s].
        last_id: highest that is looked at.
        baudrates: [bit/s].
        progress: called with what is tried, and with replies that are not from a servo.
        patience: silence after a ping to all [s].

    Raises:
        PortLostError: the only port cannot be opened; of several, it is skipped with a message.
    """
    for name in names:
        if warning := latency_warning(name):
            progress(warning)
        timer = latency_timer(name)
        timeout = max(reply_timeout, 0.0 if timer is None else 1.5e-3 * timer[0])
        try:
            with ServoBus(name, baudrates[0], timeout) as bus:
                for baudrate in baudrates:
                    progress(f"{name}: {baudrate} bit/s, ids 0 to {last_id}")
                    yield from _at_rate(bus, baudrate, last_id, timeout, progress, patience)
        except PortLostError as error:
            if len(names) == 1:
                raise
            progress(str(error))


def _at_rate(
    bus: ServoBus, baudrate: int, last_id: int, reply_timeout: float, progress: Callable[[str], None], patience: float
) -> Iterator[FoundServo]:
    bus.transport.set_baudrate(baudrate)
    models: dict[int, int] = {}
    garbled = False
    for _ in range(PASSES):
        found, unintelligible = ping_all(bus.transport, patience)
        models |= found
        garbled = garbled or unintelligible
    bus.transport.set_baudrate(baudrate)
    for identifier, model in sorted(models.items()):
        bus.model = model_of(model) or bus.model
        if identifier <= last_id:
            yield FoundServo(bus.port, baudrate, identifier, model, _doubt(bus, identifier, reply_timeout))
        else:
            progress(f"{bus.port}: {baudrate} bit/s: id {identifier} replies as well, beyond --last-id")
    if garbled:
        progress(
            f"{bus.port}: {baudrate} bit/s: {GARBLED}: several servos with one id, or noise? Connect one at a time"
        )


def _doubt(bus: ServoBus, identifier: int, reply_timeout: float) -> str:
    """Explain replies that are garbled, because two servos write at once, or late; empty for good ones."""
    bus.transport.set_reply_timeout(max(reply_timeout, PATIENT_SECONDS))
    lost, took = 0, []
    for register in PROOF * PROOFS:
        began = time.monotonic()
        try:
            bus.read(identifier, register)
            took.append(time.monotonic() - began)
        except NoReplyError:
            lost += 1
        except RefusedError:
            return ""
    if lost:
        return ", whose replies collide: are there several with this id? Plug in one at a time"
    if min(took) > DELAYED_SECONDS:
        return f", which takes {min(took) * 1e3:.0f} ms to reply: set the adapter's latency timer to 1 ms"
    return ""
