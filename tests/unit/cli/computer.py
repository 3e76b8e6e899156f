"""A computer for the doctor: folders for /proc and /sys, and a rig on it."""

from pathlib import Path
from typing import Any

from tendond.cli.doctor.check import Check, CheckOutcome, Machine, Rig
from tendond.schemas.config.rig import check_config


class Computer:
    """A folder each for /proc and /sys, and a rig on it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.synchronised = True
        self.sections: dict[str, Any] = {}
        self.config_file: Path | None = folder / "rig.toml"

    def write(self, path: str, text: str) -> None:
        file = self.folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    @property
    def rig(self) -> Rig:
        system = Machine(self.folder / "proc", self.folder / "sys", lambda: self.synchronised)
        return Rig(check_config(self.sections, "test"), self.config_file, self.folder / "log", machine=system)

    def outcome(self, check: Check) -> CheckOutcome | None:
        result = check(self.rig)
        assert result is None or bool(result.remedy) is (result.outcome is not CheckOutcome.PASS), result
        return None if result is None else result.outcome
