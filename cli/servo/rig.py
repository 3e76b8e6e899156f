"""A rig's servos as the tools see them: port, calibration, where the tendons are; and the operator's word."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from tendond.cli.common import load_config, present, say
from tendond.daemon.errors import DaemonError
from tendond.drivers.dynamixel.calibration import Calibration, load_calibration
from tendond.drivers.dynamixel.places import places_file, read_places, write_places
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import ServoBus
from tendond.drivers.dynamixel.servos import find
from tendond.drivers.dynamixel.tools.requirements import require
from tendond.drivers.dynamixel.turns import Located, locate
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.servo import ServoSection

Ask = Callable[[str], str]


class RefusedByOperatorError(DaemonError):
    """The operator said no."""


@dataclass(frozen=True)
class ServoRig:
    """A configuration with servos, its folder and the calibration's file."""

    config: RigConfig
    section: ServoSection
    folder: Path

    @property
    def calibration_file(self) -> Path:
        """Where it is, or will be."""
        return self.folder / self.section.calibration

    @property
    def places_file(self) -> Path:
        """Where the tendons' last places are kept."""
        return places_file(self.folder, self.section)

    @property
    def ids(self) -> tuple[int, ...]:
        """Of the servos, in the order of the tendons."""
        return self.section.servo_ids(len(self.config.rod.tendon_positions))

    @property
    def tension_max(self) -> float:
        """Of [limits] [N]."""
        return self.config.limits.tension_max

    def calibration(self) -> Calibration:
        """The calibration, complete.

        Raises:
            CalibrationError: there is none for this rig.
        """
        return load_calibration(self.calibration_file, self.config.rig.name, self.ids)

    def locate(self, bus: ServoBus, calibration: Calibration, told: Mapping[int, float]) -> list[Located]:
        """Where each tendon is.

        Args:
            bus: open.
            calibration: complete.
            told: by the operator, displacement [m] by the tendon's number.

        Raises:
            ServoError: a servo does not answer, or is not what it must be.
        """
        find(bus, self.ids)
        require(bus, self.ids, self.section.answer_timeout)
        last = read_places(self.places_file, calibration)
        return [
            locate(
                self.section,
                tendon,
                bus.read(tendon.servo, table.PRESENT_POSITION),
                told.get(index, last.get(tendon.servo)),
            )
            for index, tendon in enumerate(calibration.tendons)
        ]

    def keep(self, calibration: Calibration, places: Mapping[int, float]) -> None:
        """Write down where tendons are now, by servo id [m]; that it cannot be written is only said."""
        known = {**read_places(self.places_file, calibration), **places}
        try:
            write_places(self.places_file, calibration, known)
        except OSError as error:
            say(f"{self.places_file}: cannot be written: {error.strerror}; a rebooted servo will have lost its turns")


def servo_rig(config_file: Path | None) -> ServoRig:
    """The rig of a configuration.

    Raises:
        ConfigError: it cannot be read, or has no [servo].
    """
    config = load_config(config_file)
    return ServoRig(config, present(config.servo, "servo", config_file), folder_of(config_file))


def open_bus(section: ServoSection, at: int | None = None) -> ServoBus:
    """The servos' port, at the configured rate or another [bit/s].

    Raises:
        PortLostError: it cannot be opened.
    """
    return ServoBus(section.port, at or section.baudrate, section.answer_timeout)


def folder_of(config_file: Path | None) -> Path:
    """In which paths of the configuration begin."""
    return Path() if config_file is None else config_file.parent


def confirm(question: str, yes: bool, ask: Ask) -> None:
    """Ask whether to go on.

    Raises:
        RefusedByOperatorError: the answer is not yes.
    """
    if not yes and ask(f"{question} yes or no:") != "yes":
        raise RefusedByOperatorError("nothing was done: the answer was not 'yes'")


def parse_places(texts: list[str], tendons: int) -> dict[int, float]:
    """Places that the operator tells: 'TENDON=MM' each; displacement [m] by the tendon's number.

    Raises:
        DaemonError: one is none of that.
    """
    told = {}
    for text in texts:
        number, _, place = text.partition("=")
        with suppress(ValueError):
            if int(number) in range(tendons):
                told[int(number)] = float(place) * 1e-3
                continue
        raise DaemonError(f"--at {text}: must be TENDON=MM with a tendon from 0 to {tendons - 1}, like --at 0=59.3")
    return told


def ask_terminal(question: str) -> str:
    """Put a question to the operator; the answer in small letters.

    Raises:
        RefusedByOperatorError: there is nobody to answer.
    """
    try:
        return input(f"{question} ").strip().lower()
    except EOFError:
        raise RefusedByOperatorError("nothing was done: nobody answers; give --yes if you are sure") from None
