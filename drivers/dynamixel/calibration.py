"""Where each tendon's zero is, which way its servo winds, and on what: a dated file, whole or not at all."""

import os
from datetime import UTC, datetime
from pathlib import Path

from pydantic import ValidationError

from tendond.schemas.calibration import Calibration as Calibration
from tendond.schemas.calibration import TendonCalibration as TendonCalibration
from tendond.schemas.config.rig import ConfigError
from tendond.schemas.errors.explain import explain


class CalibrationError(ConfigError):
    """A calibration that cannot be read, written, or used for this rig."""


def now() -> str:
    """The date as it stands in a calibration."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def read_calibration(path: Path) -> Calibration:
    """A file's calibration, finished or not.

    Raises:
        CalibrationError: there is none, or none that can be read.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise CalibrationError(f"{path}: no such calibration: make it with 'tendond servo calibrate'") from None
    except (OSError, UnicodeDecodeError) as error:
        raise CalibrationError(f"{path}: cannot be read: {getattr(error, 'strerror', 'is no text')}") from error
    try:
        return Calibration.model_validate_json(text)
    except ValidationError as error:
        what = explain(error, Calibration)[0]
        remedy = "run 'tendond servo calibrate', which sets it aside"
        raise CalibrationError(f"{path}: is no calibration: {what}: {remedy}") from error


def load_calibration(path: Path, rig: str, servos: tuple[int, ...]) -> Calibration:
    """A file's calibration, if it is this rig's and complete.

    Args:
        path: of the file.
        rig: name of the rig that it has to be of.
        servos: ids, in the order of the tendons.

    Raises:
        CalibrationError: it is not.
    """
    calibration = read_calibration(path)
    if calibration.rig != rig:
        raise CalibrationError(f"{path}: is of rig '{calibration.rig}', this is '{rig}': calibrate this one")
    found = tuple(tendon.servo for tendon in calibration.tendons)
    if found != servos[: len(found)] or len(found) > len(servos):
        raise CalibrationError(f"{path}: is for servos {list(found)}, the configuration has {list(servos)}")
    if len(found) < len(servos):
        raise CalibrationError(
            f"{path}: is unfinished, {len(found)} of {len(servos)} tendons: go on with 'tendond servo calibrate'"
        )
    return calibration


def save_calibration(path: Path, calibration: Calibration) -> None:
    """Write it beside the old one, then put it in its place in one step; the disk has it before this returns.

    Raises:
        CalibrationError: it cannot be written; the old one is still there.
    """
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with beside.open("w", encoding="utf-8") as file:
            file.write(calibration.model_dump_json(indent=2) + "\n")
            file.flush()
            os.fsync(file.fileno())
        beside.replace(path)
        folder = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise CalibrationError(f"{path}: cannot be written: {error.strerror}") from error


def set_aside(path: Path) -> Path | None:
    """Keep a calibration under its date's name, for the records; the new name, or none when there was none.

    Raises:
        CalibrationError: it cannot be renamed.
    """
    try:
        date = read_calibration(path).date
    except CalibrationError:
        if not path.exists():
            return None
        date = now() + "-unreadable"
    kept = path.with_name(f"{path.stem}-{date.replace(':', '').replace('+0000', 'Z')}{path.suffix}")
    try:
        path.replace(kept)
    except OSError as error:
        raise CalibrationError(f"{path}: cannot be set aside as {kept.name}: {error.strerror}") from error
    return kept
