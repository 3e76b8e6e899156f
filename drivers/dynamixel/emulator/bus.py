"""A pseudo-terminal with emulated servos behind it, in a thread of its own."""

import os
import select
import termios
import threading
import time
import tty
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from tendond.drivers.dynamixel import table
from tendond.drivers.dynamixel.emulator.protocol import (
    ALERT,
    BROADCAST,
    Error,
    Instruction,
    Packet,
    Receiver,
    fast_status,
    status,
)
from tendond.drivers.dynamixel.emulator.servo import EmulatedServo

TICK_SECONDS = 0.002
LONGEST_STEP_SECONDS = 0.02
"""Where this process could not run for longer, the servos' clocks stand still: else their watchdogs would trip although
packets are waiting, and motors would jump."""

OUTPUT_SPEED = 5
SPEEDS = {getattr(termios, f"B{rate}"): rate for rate in table.BAUD_CODES}


class EmulatedBus:
    """Servos on a serial line.

    Args:
        link: path at which the port appears, as a symbolic link to the pseudo-terminal.
        servos: on the line.

    Attributes:
        knows_fast: the servos' firmware knows Fast Sync Read.
        corrupt: so many of the next answers have a wrong CRC.
        instructions: packets understood so far, newest last, for tests.
    """

    def __init__(self, link: Path, servos: Sequence[EmulatedServo]) -> None:
        self._link = link
        self.servos = servos
        self.knows_fast = True
        self.corrupt = 0
        self.instructions: list[Packet] = []
        self._lock = threading.RLock()
        self._receiver = Receiver()
        self._ended = threading.Event()
        self._master: int | None = None
        self._slave: int | None = None
        self.plug()
        self._thread = threading.Thread(target=self._run, name="servos", daemon=True)
        self._thread.start()

    def __enter__(self) -> "EmulatedBus":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End it."""
        self._ended.set()
        self._thread.join()
        self.unplug()

    def plug(self) -> None:
        """Plug the adapter in: a port appears at the link."""
        with self._lock:
            self.unplug()
            self._master, self._slave = os.openpty()
            tty.setraw(self._slave)
            os.set_blocking(self._master, False)
            beside = self._link.with_name(self._link.name + ".new")
            beside.unlink(missing_ok=True)
            beside.symlink_to(os.ttyname(self._slave))
            beside.replace(self._link)

    def unplug(self) -> None:
        """Pull the adapter out: whoever has the port open gets errors from it."""
        with self._lock:
            for end in (self._master, self._slave):
                if end is not None:
                    os.close(end)
            self._master = self._slave = None
            self._link.unlink(missing_ok=True)

    def tell(self, change: Callable[[], None]) -> None:
        """Carry out a change of the servos between two of their steps."""
        with self._lock:
            change()

    def _run(self) -> None:
        last = time.monotonic()
        while not self._ended.is_set():
            master = self._master
            ready: list[int] = []
            if master is None:
                time.sleep(TICK_SECONDS)
            else:
                with suppress(OSError, ValueError):
                    ready, _, _ = select.select([master], [], [], TICK_SECONDS)
            with self._lock:
                now = time.monotonic()
                for servo in self.servos:
                    if not servo.silent:
                        servo.advance(min(max(now - last, 1e-6), LONGEST_STEP_SECONDS))
                last = now
                if ready and self._master == master:
                    self._serve(ready[0])

    def _serve(self, master: int) -> None:
        try:
            data = os.read(master, 4096)
        except OSError:
            return
        assert self._slave is not None
        speed = SPEEDS.get(termios.tcgetattr(self._slave)[OUTPUT_SPEED])
        servos = {servo.id: servo for servo in self.servos if not servo.silent and servo.baudrate == speed}
        for packet in self._receiver.feed(data):
            self.instructions.append(packet)
            del self.instructions[:-1000]
            answer = self._answer(servos, packet)
            if answer and self.corrupt > 0:
                self.corrupt -= 1
                answer = answer[:-1] + bytes([answer[-1] ^ 0xFF])
            with suppress(OSError):
                os.write(master, answer)

    def _answer(self, servos: dict[int, EmulatedServo], packet: Packet) -> bytes:
        """What the servos write in reply."""
        if not packet.intact:
            alone = servos.get(packet.id)
            return b"" if alone is None else status(packet.id, Error.CRC)
        if packet.id != BROADCAST:
            servo = servos.get(packet.id)
            return b"" if servo is None else self._single(servo, packet)
        if packet.instruction == Instruction.PING:
            return b"".join(self._single(servos[i], packet) for i in sorted(servos))
        if packet.instruction == Instruction.SYNC_WRITE:
            self._sync_write(servos, packet.parameters)
        if packet.instruction == Instruction.FAST_SYNC_READ and not self.knows_fast:
            return b""
        if packet.instruction in (Instruction.SYNC_READ, Instruction.FAST_SYNC_READ):
            return self._sync_read(servos, packet)
        return b""

    def _single(self, servo: EmulatedServo, packet: Packet) -> bytes:
        servo.heard()
        parameters, error, data = packet.parameters, Error.NONE, b""
        identifier = servo.id
        if packet.instruction == Instruction.PING:
            model = servo.value(table.MODEL).to_bytes(2, "little")
            data = model + bytes([servo.value(table.FIRMWARE)])
        elif packet.instruction == Instruction.READ and len(parameters) == 4:
            found = servo.read(_word(parameters), _word(parameters[2:]))
            error, data = (Error.DATA_LENGTH, b"") if found is None else (Error.NONE, found)
        elif packet.instruction == Instruction.WRITE and len(parameters) > 2:
            error = servo.write(_word(parameters), parameters[2:])
        elif packet.instruction == Instruction.REBOOT:
            servo.power_up()
        else:
            error = Error.INSTRUCTION
        return status(identifier, error | (ALERT if servo.alert else 0), data)

    def _sync_write(self, servos: dict[int, EmulatedServo], parameters: bytes) -> None:
        address, length = _word(parameters), _word(parameters[2:])
        for at in range(4, len(parameters) - length, length + 1):
            servo = servos.get(parameters[at])
            if servo is not None:
                servo.heard()
                servo.write(address, parameters[at + 1 : at + 1 + length])

    def _sync_read(self, servos: dict[int, EmulatedServo], packet: Packet) -> bytes:
        address, length = _word(packet.parameters), _word(packet.parameters[2:])
        blocks = []
        for identifier in packet.parameters[4:]:
            servo = servos.get(identifier)
            if servo is None:
                break  # each waits for the one before it
            servo.heard()
            data = servo.read(address, length)
            if data is None:
                break
            blocks.append((ALERT if servo.alert else 0, identifier, data))
        if packet.instruction == Instruction.SYNC_READ:
            return b"".join(status(identifier, error, data) for error, identifier, data in blocks)
        if not blocks:
            return b""
        return fast_status(blocks, 1 + len(packet.parameters[4:]) * (length + 4))


def _word(data: bytes) -> int:
    return int.from_bytes(data[:2], "little")
