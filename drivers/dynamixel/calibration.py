"""Calibration file: zero, sign and spool of each tendon, dated, written atomically."""

import os
from datetime import UTC, datetime
from pathlib import Path

from pydantic import ValidationError

from tendond.schemas.calibration import Calibration as Calibration
from tendond.schemas.calibration import TendonCalibration as TendonCalibration
from tendond.schemas.config.rig import ConfigError
from tendond.schemas.errors.explain import explain


class CalibrationError(ConfigError):
    """A calibration cannot be read, written, or used for this rig."""


def now() -> str:
    """Return the present date as a calibration has it."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def read_calibration(path: Path) -> Calibration:
    """Read a calibration, finished or not.

    Raises:
        CalibrationError: there is no file, or it cannot be read.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise CalibrationError(f"{path}: no such calibration: create it with 'tendond servo calibrate'") from None
    except (OSError, UnicodeDecodeError) as error:
        raise CalibrationError(f"{path}: cannot be read: {getattr(error, 'strerror', 'is not text')}") from error
    try:
        return Calibration.model_validate_json(text)
    except ValidationError as error:
        what = explain(error, Calibration)[0]
        remedy = "run 'tendond servo calibrate', which sets it aside"
        raise CalibrationError(f"{path}: is not a calibration: {what}: {remedy}") from error


def load_calibration(path: Path, rig: str, servos: tuple[int, ...]) -> Calibration:
    """Read a calibration of this rig that is complete.

    Args:
        path: path of the file.
        rig: name of the rig.
        servos: ids, in the order of the tendons.

    Raises:
        CalibrationError: it is of another rig or unfinished, or cannot be read.
    """
    calibration = read_calibration(path)
    if calibration.rig != rig:
        raise CalibrationError(f"{path}: is of rig '{calibration.rig}', this is '{rig}': calibrate this one")
    found = tuple(tendon.servo for tendon in calibration.tendons)
    if found != servos[: len(found)] or len(found) > len(servos):
        raise CalibrationError(f"{path}: is for servos {list(found)}, the configuration has {list(servos)}")
    if len(found) < len(servos):
        raise CalibrationError(
            f"{path}: is unfinished, {len(found)} of {len(servos)} tendons: continue with 'tendond servo calibrate'"
        )
    return calibration


def save_calibration(path: Path, calibration: Calibration) -> None:
    """Write a calibration and replace the old one atomically; it is on disk on return.

    Raises:
        CalibrationError: it cannot be written; the old one is unchanged.
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
    """Rename a calibration by its date, as a record; return the new name, none without a calibration.

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
