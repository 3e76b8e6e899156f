"""Input and result of a check."""

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from pathlib import Path

from tendond.cli.doctor.clock import is_synchronised
from tendond.cli.doctor.listen import BusActivity, listen
from tendond.schemas.config.rig import RigConfig


class CheckOutcome(StrEnum):
    """Verdict of a check, from best to worst."""

    PASS = "pass"
    WARN = "warn"
    FAIL = "fail"


@dataclass(frozen=True)
class CheckResult:
    """Finding, in one line, and its remedy."""

    outcome: CheckOutcome
    finding: str
    remedy: str = ""


def passed(finding: str) -> CheckResult:
    """Result of a check that passes."""
    return CheckResult(CheckOutcome.PASS, finding)


def warned(finding: str, remedy: str) -> CheckResult:
    """Result for a rig that runs, but not at its best, or for something that could not be checked."""
    return CheckResult(CheckOutcome.WARN, finding, remedy)


def failed(finding: str, remedy: str) -> CheckResult:
    """Result for a rig that cannot run."""
    return CheckResult(CheckOutcome.FAIL, finding, remedy)


@dataclass(frozen=True)
class Machine:
    """The operating system's folders; tests use their own."""

    proc: Path = Path("/proc")
    sys: Path = Path("/sys")
    is_synchronised: Callable[[], bool] = is_synchronised

    def read(self, path: Path) -> str | None:
        """Read a small file; none if it is missing or not readable."""
        try:
            return path.read_text(encoding="utf-8", errors="replace").strip()
        except OSError:
            return None


@dataclass
class Rig:
    """Rig to check.

    Attributes:
        config: valid.
        config_file: the configuration file; none: the built-in configuration.
        log_folder: folder of its logs.
        query_servos: true if servos may be queried.
        probe: true to pull each tendon slightly, one after another.
        machine: the computer.
    """

    config: RigConfig
    config_file: Path | None
    log_folder: Path
    query_servos: bool = True
    probe: bool = False
    machine: Machine = field(default_factory=Machine)

    @property
    def folder(self) -> Path:
        """Folder in which the configuration's paths begin."""
        return Path() if self.config_file is None else self.config_file.parent

    @cached_property
    def activity(self) -> BusActivity:
        """Activity on the bus, recorded for a second by the first check that needs it."""
        return listen(self.config)


Check = Callable[[Rig], CheckResult | None]
"""A check; none: it does not apply to this rig."""
