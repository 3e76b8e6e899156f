"""Emulated servos on a pseudo-terminal, set up for a rig."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Literal

from tendond.drivers.dynamixel.calibration import Calibration, TendonCalibration
from tendond.drivers.dynamixel.emulator.bus import EmulatedBus
from tendond.drivers.dynamixel.emulator.servo import EmulatedServo
from tendond.drivers.dynamixel.serial.models import MODELS
from tendond.drivers.dynamixel.spool import Spool
from tendond.drivers.dynamixel.tools.requirements import requirements
from tendond.schemas.config.servo import ServoSection

BAUDRATE = 1_000_000
REPLY_SECONDS = 0.5
"""Generous: the emulator is a thread of a busy machine, which may stand still for a while. Only silence costs it."""

SHORT_SECONDS = 0.1
"""Timeout for tests in which a servo is silent."""


def set_up(servo: EmulatedServo, section: ServoSection | None = None) -> None:
    """Set a servo up as `tendond servo setup` does."""
    for one in requirements(servo.model, section or ServoSection()):
        servo.put(one.register, one.wanted)


@contextmanager
def emulated(
    folder: Path, count: int = 4, *, position: int = 2048, ready: bool = True, section: ServoSection | None = None
) -> Iterator[EmulatedBus]:
    """Yield a bus with servos 1 to `count` of the section's model, set up for it when `ready`."""
    model = MODELS[(section or ServoSection()).model]
    servos = [EmulatedServo(i + 1, BAUDRATE if ready else 57600, position, model) for i in range(count)]
    if ready:
        for servo in servos:
            set_up(servo, section)
    with EmulatedBus(folder / "ttyUSB0", servos) as bus:
        yield bus


RADIUS = 0.015
SPRING = 600.0
"""Stiffness of the tendons on the spools [N/m]."""


def calibration(
    signs: Sequence[Literal[-1, 1]] = (1, -1, 1, -1), zero: int = 2048, rig: str = "paper", ticks_per_turn: int = 4096
) -> Calibration:
    """Return a calibration of servos 1, 2 and so on."""
    tendons = (
        TendonCalibration(servo=index + 1, zero=zero, sign=sign, spool_radius=RADIUS, ticks_per_turn=ticks_per_turn)
        for index, sign in enumerate(signs)
    )
    return Calibration(rig=rig, date="2026-01-01T00:00:00+00:00", tendons=tuple(tendons))


def hang_springs(servos: Sequence[EmulatedServo], calibrated: Calibration) -> None:
    """Hang a spring on each spool, slack below zero."""

    def spring(tendon: TendonCalibration) -> Callable[[float], float]:
        spool = Spool(tendon)

        def torque(position: float) -> float:
            pull = SPRING * max(0.0, spool.displacement(round(position)))
            return -tendon.sign * pull * tendon.spool_radius

        return torque

    for servo, tendon in zip(servos, calibrated.tendons, strict=True):
        servo.torque = spring(tendon)
