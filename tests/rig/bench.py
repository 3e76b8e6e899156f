"""The servo driver on emulated servos behind a pseudo-terminal, cycled by the test."""

import math
import time
from collections.abc import Callable, Mapping
from pathlib import Path

from tendond.drivers.dynamixel.driver.driver import ServoDriver
from tendond.drivers.dynamixel.driver.phase import DriverPhase
from tendond.drivers.dynamixel.emulator.bus import EmulatedBus
from tendond.drivers.dynamixel.serial.bus import ServoBus
from tendond.drivers.dynamixel.serial.models import MODELS
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.messages import TendonCommand
from tests.rig.servos import BAUDRATE, REPLY_SECONDS, calibration, hang_springs

PATIENCE_SECONDS = 20.0
SLACK = (0.0, 0.0, 0.0, 0.0)
PULLED = (0.015, 0.0, 0.01, 0.0)


def section(**changes: object) -> ServoSection:
    """Short times, so that the tests are short; generous where a busy machine could be late."""
    fields = {
        "reply_timeout": REPLY_SECONDS,
        "fault_hold": 0.1,
        "release_rate": 0.2,
        "release_time": 1.5,
        "hold_time": 0.2,
        "command_timeout": 0.3,
        "watchdog": 1.0,
        **changes,
    }
    return ServoSection.model_validate(fields)


class DriverBench:
    """Driver on emulated servos with springs, cycled by the test."""

    def __init__(self, servos: EmulatedBus, port: Path, settings: ServoSection, tension_max: float = math.inf) -> None:
        self.servos = servos
        self.section = settings
        self.port = str(port)
        self.calibration = calibration(ticks_per_turn=settings.motor.ticks_per_turn)
        hang_springs(servos.servos, self.calibration)
        self.seq = 0
        self.tension_max = tension_max
        self.driver = self.new_driver()

    def new_driver(self, last: Mapping[int, float] | None = None) -> ServoDriver:
        """Return a new driver, with `last` or the places that the previous one left."""
        if last is None:
            last = dict(self.driver.places) if hasattr(self, "driver") else {}
        return ServoDriver(
            self.section,
            self.calibration,
            lambda: ServoBus(self.port, BAUDRATE, self.section.reply_timeout, MODELS[self.section.model]),
            last,
            self.tension_max,
        )

    def command(self, displacement: tuple[float, ...], armed: bool = True) -> TendonCommand:
        self.seq += 1
        zeros = (0.0,) * len(displacement)
        return TendonCommand(
            seq=self.seq, stamp_ns=0, pose_seq=None, displacement=displacement, tension=zeros, armed=armed
        )

    def until(
        self, wanted: Callable[[ServoDriver], bool], displacement: tuple[float, ...] | None = None, armed: bool = True
    ) -> None:
        """Cycle, with a command in each or none at all."""
        deadline = time.monotonic() + PATIENCE_SECONDS
        while not wanted(self.driver):
            assert time.monotonic() < deadline, (self.driver.phase, self.driver.report, self.driver.displacement)
            command = None if displacement is None else self.command(displacement, armed)
            self.driver.cycle(time.monotonic(), command)
            time.sleep(0.01)

    def pull(self) -> None:
        """Arm, and pull two tendons."""
        self.until(
            lambda one: one.phase is DriverPhase.OFF and not one.objection and one.commands.disarmed, SLACK, armed=False
        )
        self.until(lambda one: abs(one.displacement[0] - PULLED[0]) < 1e-4, PULLED)
        assert self.driver.phase is DriverPhase.ON

    @property
    def torques(self) -> list[bool]:
        return [servo.energised for servo in self.servos.servos if not servo.silent]

    def ends_slack_and_off(self, fault: str) -> None:
        """Check that the fault is latched, tendons are released, torque is off, and armed commands change nothing."""
        self.until(lambda one: one.phase is DriverPhase.OFF, PULLED)
        assert fault in self.driver.fault
        for _ in range(20):
            self.driver.cycle(time.monotonic(), self.command(PULLED))
        assert self.driver.phase is DriverPhase.OFF
        assert not any(self.torques)
