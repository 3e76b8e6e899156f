"""Pseudo-terminal with emulated servos behind it, in its own thread."""

import bisect
import fcntl
import os
import random
import select
import struct
import threading
import time
import tty
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from tendond.drivers.dynamixel.emulator.line import ServoLine
from tendond.drivers.dynamixel.emulator.protocol import Packet, Receiver
from tendond.drivers.dynamixel.emulator.servo import EmulatedServo

TICK_SECONDS = 0.002
LONGEST_STEP_SECONDS = 0.02
"""Longest time step of the servos [s]: where this process could not run for longer, their clocks stand still, else
their watchdogs would trip although packets are waiting."""

REMEMBERED = 0.15
"""Age up to which positions are remembered [s]."""

TCGETS2 = 0x802C542A
"""Linux's request for a terminal's settings with its speed as a number: 4.5 Mbit/s has no name."""

TERMIOS2 = struct.Struct("4IB19B2I")


class EmulatedBus:
    """Servos on a serial line.

    Args:
        link: path at which the port appears, as a symbolic link to the pseudo-terminal.
        servos: servos on the line.

    Attributes:
        knows_fast: the servos' firmware knows Fast Sync Read.
        corrupt: number of next replies with a wrong CRC.
        loss: probability of a wrong CRC in any other reply.
        late: time by which the adapter delays every reply [s].
        instructions: packets understood so far, newest last, for tests.
        errors: exceptions in the thread, which are errors of the emulator, for tests.
    """

    def __init__(self, link: Path, servos: Sequence[EmulatedServo]) -> None:
        self._link = link
        self.servos = servos
        self.corrupt = 0
        self.loss = 0.0
        self.late = 0.0
        self._passed: deque[tuple[float, list[float]]] = deque()
        self.instructions: list[Packet] = []
        self.errors: list[Exception] = []
        self._line = ServoLine()
        self._chance = random.Random(0)
        self._pending: list[tuple[float, bytes]] = []
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
        """Stop the thread and remove the port."""
        self._ended.set()
        self._thread.join()
        self.unplug()

    @property
    def knows_fast(self) -> bool:
        """True where the firmware supports Fast Sync Read."""
        return self._line.knows_fast

    @knows_fast.setter
    def knows_fast(self, value: bool) -> None:
        self._line.knows_fast = value

    @property
    def thread_id(self) -> int:
        """The operating system's number of the servos' thread."""
        assert self._thread.native_id is not None
        return self._thread.native_id

    @property
    def alive(self) -> bool:
        """True while the thread runs."""
        return self._thread.is_alive()

    def plug(self) -> None:
        """Plug in the adapter: a port appears at the link."""
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
        """Unplug the adapter: an open port then returns errors."""
        with self._lock:
            for end in (self._master, self._slave):
                if end is not None:
                    os.close(end)
            self._master = self._slave = None
            self._pending.clear()
            self._link.unlink(missing_ok=True)

    def apply(self, change: Callable[[], None]) -> None:
        """Change the servos between two of their steps."""
        with self._lock:
            change()

    def positions(self, at: float) -> list[float]:
        """Return the servos' positions at a time of the last tenth of a second [s], monotonic clock [ticks].

        A plant that is late takes those of its own time: with those of now its tendons would be pulled by a jump.
        """
        with self._lock:
            passed = list(self._passed)
            now = [servo.position for servo in self.servos]
        times = [time for time, _ in passed]
        after = bisect.bisect(times, at)
        if not passed or after == len(passed):
            return now
        if after == 0:
            return passed[0][1]
        (first, before), (second, then) = passed[after - 1 : after + 1]
        part = (at - first) / (second - first)
        return [a + part * (b - a) for a, b in zip(before, then, strict=True)]

    def _run(self) -> None:
        last = time.monotonic()
        while not self._ended.is_set():
            master = self._master
            ready: list[int] = []
            if master is None:
                time.sleep(TICK_SECONDS)
            else:
                with suppress(OSError, ValueError):
                    ready, _, _ = select.select([master], [], [], self._patience())
            with self._lock:
                now = time.monotonic()
                try:
                    self._pass(now - last)
                    self._passed.append((now, [servo.position for servo in self.servos]))
                    while now - self._passed[0][0] > REMEMBERED:
                        self._passed.popleft()
                    if self._master is not None and self._master == master:
                        if ready:
                            self._serve(master, now)
                        self._send(master)
                except Exception as error:  # a thread that dies would take all servos with it
                    self.errors.append(error)
                last = now

    def _patience(self) -> float:
        """Return the time until the next reply or the next step of the servos [s]."""
        if not self._pending:
            return TICK_SECONDS
        return min(max(self._pending[0][0] - time.monotonic(), 0.0), TICK_SECONDS)

    def _pass(self, duration: float) -> None:
        for servo in self.servos:
            if not servo.silent:
                servo.advance(min(max(duration, 1e-6), LONGEST_STEP_SECONDS))

    def _serve(self, master: int, now: float) -> None:
        try:
            data = os.read(master, 4096)
        except OSError:
            return
        speed = self._speed()
        servos = [servo for servo in self.servos if not servo.deaf and servo.baudrate == speed]
        for packet in self._receiver.feed(data):
            self.instructions.append(packet)
            del self.instructions[:-1000]
            reply, delay = self._line.reply(servos, packet)
            if not reply:
                continue
            if self.corrupt > 0 or self._chance.random() < self.loss:
                self.corrupt = max(0, self.corrupt - 1)
                reply = reply[:-1] + bytes([reply[-1] ^ 0xFF])
            self._pending.append((now + delay + self.late, reply))

    def _send(self, master: int) -> None:
        while self._pending and self._pending[0][0] <= time.monotonic():
            _, reply = self._pending.pop(0)
            with suppress(OSError):
                os.write(master, reply)

    def _speed(self) -> int:
        """Return the baud rate of the open port [bit/s]."""
        assert self._slave is not None
        settings = fcntl.ioctl(self._slave, TCGETS2, bytes(TERMIOS2.size))
        return int(TERMIOS2.unpack(settings)[-1])
