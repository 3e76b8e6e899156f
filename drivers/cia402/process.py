"""Process of the driver for drives: that of the servos, on another bus."""

from collections.abc import Mapping
from pathlib import Path

from tendond.drivers.cia402.bus import DriveBus
from tendond.drivers.cia402.driver import DriveDriver
from tendond.drivers.cia402.group import DriveGroup
from tendond.drivers.dynamixel.calibration import Calibration
from tendond.drivers.dynamixel.process import ServoProcess
from tendond.drivers.host import Host
from tendond.schemas.config.drives import DrivesSection
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.servo import ServoSection


def drive_driver(
    section: ServoSection,
    drives: DrivesSection,
    calibration: Calibration,
    last: Mapping[int, float],
    tension_max: float,
) -> DriveDriver:
    """Open the drives of a rig.

    Args:
        section: [servo]. drives: [drives].
        calibration: complete.
        last: last known displacement of each tendon, by node id [m].
        tension_max: limits.tension_max [N].

    Raises:
        ServoError: the bus cannot be opened, or a drive cannot be set up.
    """
    nodes = tuple(tendon.servo for tendon in calibration.tendons)

    def make_group(
        servo: ServoSection, made: Calibration, bus: DriveBus, _: Mapping[int, float], largest: float
    ) -> DriveGroup:
        return DriveGroup(drives, servo, made, bus, largest)

    return DriveDriver(section, calibration, lambda: DriveBus(drives, nodes), last, tension_max, make_group)


class DriveProcess(ServoProcess):
    """Driver of drives on the bus.

    Args:
        config: configuration of the rig. section: its [servo]. drives: its [drives].
        folder: folder of the configuration, to which the calibration's path is relative.
        host: surroundings of the process.
    """

    awaits_commands = False
    """A drive interpolates between the targets of two SYNCs, which therefore come at equal times."""

    def __init__(
        self, config: RigConfig, section: ServoSection, drives: DrivesSection, folder: Path, host: Host
    ) -> None:
        super().__init__(config, section, folder, host)
        self._drives = drives

    def _ids(self, tendons: int) -> tuple[int, ...]:
        return self._drives.node_ids(tendons)

    def _driver(self, calibration: Calibration, last: dict[int, float]) -> DriveDriver:
        return drive_driver(self._section, self._drives, calibration, last, self._config.limits.tension_max)

    @property
    def _motors(self) -> str:
        return f"drives on {self._drives.interface} {self._drives.channel}"
