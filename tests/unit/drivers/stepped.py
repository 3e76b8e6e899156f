"""Servo driver on emulated servos in simulated time: the SDK's packets without a terminal, a clock or a thread."""

from collections.abc import Callable, Sequence

import pytest

from tendond.drivers.dynamixel.driver.driver import ServoDriver
from tendond.drivers.dynamixel.emulator.line import ServoLine
from tendond.drivers.dynamixel.emulator.protocol import Receiver
from tendond.drivers.dynamixel.emulator.servo import EmulatedServo
from tendond.drivers.dynamixel.serial.bus import ServoBus
from tendond.drivers.dynamixel.serial.models import MODELS
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.messages import TendonCommand
from tests.rig.servos import BAUDRATE, REPLY_SECONDS, calibration, set_up

STEP = 0.0005
"""Time step of the servos [s]."""


class InstantSerial:
    """A serial port whose servos reply at once; stands for pyserial's."""

    def __init__(self, servos: Sequence[EmulatedServo]) -> None:
        self._servos = servos
        self._line, self._receiver, self._replies = ServoLine(), Receiver(), bytearray()

    @property
    def in_waiting(self) -> int:
        return len(self._replies)

    def write(self, data: bytes) -> int:
        for packet in self._receiver.feed(bytes(data)):
            self._replies += self._line.reply(self._servos, packet)[0]
        return len(data)

    def read(self, length: int) -> bytes:
        data = bytes(self._replies[:length])
        del self._replies[:length]
        return data

    def reset_input_buffer(self) -> None:
        self._replies.clear()

    def flush(self) -> None:
        pass

    def close(self) -> None:
        pass


class SteppedBench:
    """A driver and its servos, cycled in simulated time.

    Args:
        section: [servo].
        tension_max: of [limits] [N].
        monkeypatch: replaces pyserial's port.
        step: of the servos' time [s].
    """

    def __init__(
        self, section: ServoSection, tension_max: float, monkeypatch: pytest.MonkeyPatch, step: float = STEP
    ) -> None:
        self.section = section
        self._step = step
        model = MODELS[section.model]
        self.servos = [EmulatedServo(index + 1, BAUDRATE, model=model) for index in range(4)]
        for servo in self.servos:
            set_up(servo, section)
        serial = InstantSerial(self.servos)
        monkeypatch.setattr("serial.Serial", lambda **_: serial)
        self.now, self._seq = 0.0, 0
        self.calibration = calibration(ticks_per_turn=section.motor.ticks_per_turn)
        self.driver = ServoDriver(
            section, self.calibration, lambda: ServoBus("none", BAUDRATE, REPLY_SECONDS, model), {}, tension_max
        )

    def cycle(self, displacement: Sequence[float], *, armed: bool, during: Callable[[], None] = lambda: None) -> None:
        """Run one cycle of the driver, then its period of the servos.

        Args:
            displacement: commanded, of the tendons [m].
            armed: of the command.
            during: called after each of the servos' steps.
        """
        self._seq += 1
        values = tuple(displacement)
        command = TendonCommand(
            seq=self._seq, stamp_ns=0, pose_seq=None, displacement=values, tension=(0.0,) * len(values), armed=armed
        )
        self.now += self.section.period
        self.driver.cycle(self.now, command)
        for _ in range(round(self.section.period / self._step)):
            for servo in self.servos:
                servo.advance(self._step)
            during()
