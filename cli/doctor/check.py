"""What a check is given, and what it gives back."""

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from pathlib import Path

from tendond.cli.doctor.clock import is_synchronised
from tendond.cli.doctor.listen import Heard, listen
from tendond.schemas.config.rig import RigConfig


class Outcome(StrEnum):
    """Of a check; the worst comes last."""

    PASS = "pass"
    WARN = "warn"
    FAIL = "fail"


@dataclass(frozen=True)
class Result:
    """What was found, in one line, and what to do about it."""

    outcome: Outcome
    finding: str
    remedy: str = ""


def good(finding: str) -> Result:
    """Nothing is wrong."""
    return Result(Outcome.PASS, finding)


def doubtful(finding: str, remedy: str) -> Result:
    """The rig runs, but not as well as it could, or something could not be looked at."""
    return Result(Outcome.WARN, finding, remedy)


def bad(finding: str, remedy: str) -> Result:
    """The rig does not run so."""
    return Result(Outcome.FAIL, finding, remedy)


@dataclass(frozen=True)
class Machine:
    """Where the operating system shows itself; tests have folders of their own."""

    proc: Path = Path("/proc")
    sys: Path = Path("/sys")
    is_synchronised: Callable[[], bool] = is_synchronised

    def read(self, path: Path) -> str | None:
        """A small file's text; none where there is none, or none that may be read."""
        try:
            return path.read_text(encoding="utf-8", errors="replace").strip()
        except OSError:
            return None


@dataclass
class Rig:
    """What is looked at.

    Attributes:
        config: valid.
        config_file: it is from, if from a file.
        log_folder: of its logs.
        ask_servos: whether servos may be asked for what they are.
        probe: whether the tendons are pulled a little, one after another.
        machine: that it runs on.
    """

    config: RigConfig
    config_file: Path | None
    log_folder: Path
    ask_servos: bool = True
    probe: bool = False
    machine: Machine = field(default_factory=Machine)

    @property
    def folder(self) -> Path:
        """In which paths of the configuration begin."""
        return Path() if self.config_file is None else self.config_file.parent

    @cached_property
    def heard(self) -> Heard:
        """On the bus, for a second; listened for once, by the first check that wants it."""
        return listen(self.config)


Check = Callable[[Rig], Result | None]
"""None: it does not apply to this rig."""
