"""The driver on emulated drives: python-can's virtual bus, the drives' time advanced by each SYNC."""

import itertools
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import can

from tendond.drivers.cia402.emulated_bus import EmulatedDrives
from tendond.drivers.cia402.emulator import EmulatedDrive
from tendond.drivers.cia402.process import drive_driver
from tendond.drivers.dynamixel.calibration import Calibration
from tendond.drivers.dynamixel.spool import Spool
from tendond.schemas.config.drives import DrivesSection
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.messages import TendonCommand
from tests.rig.servos import RADIUS, calibration

COUNTS = 65536
RATED = 2.0
"""Rated torque [N m]."""

SPRING = 600.0
"""Stiffness of the tendons on the spools [N/m]."""

REPLY_SECONDS = 0.1
"""Generous: the drives are a thread of a busy machine. Only silence costs it."""

_channels = itertools.count()


def drive_calibration(rig: str = "paper") -> Calibration:
    """Return a calibration of drives 1 to 4."""
    return calibration(zero=1000, rig=rig, ticks_per_turn=COUNTS)


def emulated_drives(made: Calibration) -> list[EmulatedDrive]:
    """Return drives at the zeros of a calibration, with a spring on each spool, slack below zero."""
    drives = []
    for tendon in made.tendons:
        drive, spool = EmulatedDrive(tendon.servo), Spool(tendon)
        drive.position = drive.rest = float(tendon.zero)

        def load(position: float, spool: Spool = spool) -> float:
            pull = SPRING * max(0.0, spool.displacement(round(position)))
            return spool.calibration.sign * 1000.0 * pull * RADIUS / RATED

        drive.load = load
        drives.append(drive)
    return drives


class DriveBench:
    """A driver and its drives in simulated time."""

    def __init__(self, drives: EmulatedDrives, made: Calibration, section: DrivesSection, servo: ServoSection) -> None:
        self.drives, self.calibration, self.section, self.servo = drives, made, section, servo
        self.now, self._seq = 0.0, 0
        self.driver = drive_driver(servo, section, made, {}, 20.0)

    @property
    def each(self) -> list[EmulatedDrive]:
        """The drives, in the order of the tendons."""
        return self.drives.drives

    def command(self, displacement: Sequence[float], *, armed: bool) -> TendonCommand:
        """Return the next command."""
        self._seq += 1
        return TendonCommand(
            seq=self._seq,
            stamp_ns=0,
            pose_seq=None,
            displacement=tuple(displacement),
            tension=(0.0,) * len(displacement),
            armed=armed,
        )

    def cycle(self, displacement: Sequence[float] | None, *, armed: bool = True, count: int = 1) -> None:
        """Run cycles of the driver; none: without commands."""
        for _ in range(count):
            self.now += self.servo.period
            sent = None if displacement is None else self.command(displacement, armed=armed)
            self.driver.cycle(self.now, sent)

    @property
    def powered(self) -> list[bool]:
        """Which drives have torque."""
        return [drive.powered for drive in self.each]


@contextmanager
def drive_bench(servo: ServoSection | None = None, **section: Any) -> Iterator[DriveBench]:
    """Yield a bench whose drives are set up.

    Args:
        servo: [servo].
        section: keys of [drives].
    """
    channel = f"drives {next(_channels)}"
    made, servo = drive_calibration(), servo or ServoSection()
    keys = {"counts_per_turn": COUNTS, "rated_torque": RATED, "reply_timeout": REPLY_SECONDS, **section}
    drives = DrivesSection.model_validate({"interface": "virtual", "channel": channel, **keys})
    bus = can.Bus(interface="virtual", channel=channel, ignore_config=True)
    with EmulatedDrives(bus, emulated_drives(made), servo.period) as emulated:
        bench = DriveBench(emulated, made, drives, servo)
        try:
            yield bench
        finally:
            bench.driver.session.bus.close()
