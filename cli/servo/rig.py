"""The rig of a servo command, from its configuration; the operator's consent."""

from contextlib import suppress
from pathlib import Path

from tendond.cli.common import load_config, present, say
from tendond.daemon.errors import DaemonError
from tendond.drivers.dynamixel.tools.calibrate import Ask
from tendond.drivers.dynamixel.tools.rig import ServoRig
from tendond.schemas.config.rig import ConfigError, RigConfig
from tendond.schemas.config.servo import ServoSection


class RefusedByOperatorError(DaemonError):
    """Error of a command that the operator did not confirm."""


def servo_rig(config_file: Path | None) -> ServoRig:
    """Load the rig of a configuration.

    Raises:
        ConfigError: it cannot be read, has no [servo], or has drives.
    """
    config = load_config(config_file)
    refuse_drives(config)
    return ServoRig(config, present(config.servo, "servo", config_file), folder_of(config_file), say)


def servo_section(config_file: Path | None) -> ServoSection:
    """Return [servo] of a configuration, or its defaults without one.

    Raises:
        ConfigError: it cannot be read, or has drives.
    """
    config = load_config(config_file)
    refuse_drives(config)
    return config.servo or ServoSection()


def refuse_drives(config: RigConfig) -> None:
    """Refuse a configuration whose motors are no Dynamixel servos.

    Raises:
        ConfigError: it has [drives].
    """
    if config.drives is not None:
        raise ConfigError(
            "this command is for Dynamixel servos, and the configuration has [drives]: set drives up with their maker's"
            " program; docs/howto/cia402.md has their calibration"
        )


def folder_of(config_file: Path | None) -> Path:
    """Return the folder in which the configuration's paths begin."""
    return Path() if config_file is None else config_file.parent


def confirm(question: str, yes: bool, ask: Ask) -> None:
    """Ask the operator for confirmation.

    Raises:
        RefusedByOperatorError: the operator did not enter yes.
    """
    if not yes and ask(f"{question} yes or no:") != "yes":
        raise RefusedByOperatorError("nothing was done: not confirmed with 'yes'")


def parse_places(texts: list[str], tendons: int) -> dict[int, float]:
    """Parse 'TENDON=MM' texts into displacements [m] by the tendon's number.

    Raises:
        DaemonError: a text has another form.
    """
    given = {}
    for text in texts:
        number, _, place = text.partition("=")
        with suppress(ValueError):
            if int(number) in range(tendons):
                given[int(number)] = float(place) * 1e-3
                continue
        raise DaemonError(f"--at {text}: must be TENDON=MM with a tendon from 0 to {tendons - 1}, like --at 0=59.3")
    return given


def ask_terminal(question: str) -> str:
    """Ask the operator on the terminal, and return the input in lower case.

    Raises:
        RefusedByOperatorError: the input is closed.
    """
    try:
        return input(f"{question} ").strip().lower()
    except EOFError:
        raise RefusedByOperatorError("nothing was done: no input; use --yes to skip the question") from None
