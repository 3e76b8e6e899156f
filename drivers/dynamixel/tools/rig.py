"""A rig's servos as the tools use them: port, calibration, where the tendons are."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from tendond.drivers.dynamixel.calibration import Calibration, load_calibration
from tendond.drivers.dynamixel.checks import find
from tendond.drivers.dynamixel.places import places_file, read_places, write_places
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import ServoBus
from tendond.drivers.dynamixel.serial.models import MODELS
from tendond.drivers.dynamixel.tools.requirements import require
from tendond.drivers.dynamixel.turns import Located, locate
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.servo import ServoSection


@dataclass(frozen=True)
class ServoRig:
    """A configuration with servos.

    Attributes:
        config: configuration of the rig.
        section: its [servo].
        folder: folder in which the configuration's paths begin.
        say: prints a line for people.
    """

    config: RigConfig
    section: ServoSection
    folder: Path
    say: Callable[[str], None]

    @property
    def calibration_file(self) -> Path:
        """Path of the calibration."""
        return self.folder / self.section.calibration

    @property
    def places_file(self) -> Path:
        """Path of the tendons' last positions."""
        return places_file(self.folder, self.section)

    @property
    def ids(self) -> tuple[int, ...]:
        """Ids of the servos, in the order of the tendons."""
        return self.section.servo_ids(len(self.config.rod.tendon_positions))

    @property
    def tension_max(self) -> float:
        """Maximum tension, limits.tension_max [N]."""
        return self.config.limits.tension_max

    def calibration(self) -> Calibration:
        """Load the calibration.

        Raises:
            CalibrationError: there is none for this rig.
        """
        return load_calibration(self.calibration_file, self.config.rig.name, self.ids)

    def locate(self, bus: ServoBus, calibration: Calibration, given: Mapping[int, float]) -> list[Located]:
        """Locate each tendon.

        Args:
            bus: open.
            calibration: complete.
            given: displacement [m] by the tendon's number, as the operator measured it.

        Raises:
            ServoError: a servo does not reply, or is not what it must be.
        """
        find(bus, self.ids)
        require(bus, self.ids, self.section)
        last = read_places(self.places_file, calibration)
        return [
            locate(
                self.section,
                tendon,
                bus.read(tendon.servo, table.PRESENT_POSITION),
                given.get(index, last.get(tendon.servo)),
            )
            for index, tendon in enumerate(calibration.tendons)
        ]

    def keep(self, calibration: Calibration, places: Mapping[int, float]) -> None:
        """Save the tendons' displacements by servo id [m]; a file that cannot be written is a warning."""
        known = {**read_places(self.places_file, calibration), **places}
        try:
            write_places(self.places_file, calibration, known)
        except OSError as error:
            self.say(
                f"{self.places_file}: cannot be written: {error.strerror}; a rebooted servo will have lost its turns"
            )


def open_bus(section: ServoSection, at: int | None = None) -> ServoBus:
    """Open the servos' port, at the configured rate or another [bit/s].

    Raises:
        PortLostError: it cannot be opened.
    """
    return ServoBus(section.port, at or section.baudrate, section.reply_timeout, MODELS[section.model])
