"""Checks of files: logs, kernels, the calibration."""

import os
import tempfile
import time
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from tendond.cli.common import SYSTEM_LOGS
from tendond.cli.doctor.check import CheckResult, Rig, failed, passed, warned
from tendond.cli.kernel_folder import TEMPORARY, VARIABLE
from tendond.daemon.recording.recorder import FLUSH_SECONDS
from tendond.daemon.recording.storage.retention import GIGABYTE, MEGABYTE, existing, retention
from tendond.drivers.dynamixel.calibration import CalibrationError, load_calibration

TRIAL_BYTES, BLOCK_BYTES = 8_000_000, 128_000
SLOW_BYTES = 5e6
"""Write speed [bytes/s] below which entries may be dropped; a log at 100 Hz needs a tenth of it."""

FILES_LEFT = 10
"""Number of files of log.split_size below which the disk is nearly full."""

CALIBRATION_DAYS = 30.0

FEW_DAYS = 7.0
"""Days of space left below which to warn, where old logs are not removed."""


def log_space(rig: Rig) -> CheckResult:
    """Check the space for logs, and how long it lasts at the rate of the last days."""
    folder = existing(rig.log_folder)
    name, section = rig.config.rig.name, rig.config.log
    kept = retention(section, rig.log_folder, name, service=rig.log_folder.resolve().is_relative_to(SYSTEM_LOGS))
    space = replace(kept, folder=folder).disk_space()
    finding = f"{space.free / GIGABYTE:.1f} GB free for {rig.log_folder}, {space.used / GIGABYTE:.1f} GB of logs"
    if space.size is not None:
        finding += f" of {space.size / GIGABYTE:.1f} GB that may be kept"
    if space.rate is not None and space.days is not None:
        then = "the oldest are removed" if kept.size is not None else "the disk is full"
        finding += f"; at {space.rate / GIGABYTE:.2f} GB a day {then} in {space.days:.1f} days"
    size = kept.split_bytes(section.split_size * MEGABYTE)
    if space.free < size:
        return failed(f"{finding}; less than one file of log.split_size", "remove old logs, or log to another disk")
    if space.free < FILES_LEFT * size:
        return warned(f"{finding}; fewer than {FILES_LEFT} files of log.split_size", "remove old logs soon")
    if kept.size is None and space.days is not None and space.days < FEW_DAYS:
        return warned(finding, "set log.keep_size, or remove old logs soon")
    return passed(finding)


def log_speed(rig: Rig) -> CheckResult:
    """Check that the disk keeps up with the recorder: write, sync and remove some megabytes."""
    folder = existing(rig.log_folder)
    try:
        with tempfile.TemporaryFile(dir=folder) as file:
            started = time.monotonic()
            for _ in range(TRIAL_BYTES // BLOCK_BYTES):
                file.write(os.urandom(BLOCK_BYTES))
            file.flush()
            before = time.monotonic()
            os.fsync(file.fileno())
            ended = time.monotonic()
    except OSError as error:
        return warned(
            f"{folder}: not tested: {error.strerror}",
            f"run it as the user that logs: sudo -u tendond tendond doctor ({folder})",
        )
    speed, sync = TRIAL_BYTES / (ended - started), ended - before
    finding = f"{speed / 1e6:.0f} MB/s, {sync * 1e3:.0f} ms to sync {TRIAL_BYTES / 1e6:g} MB"
    if speed < SLOW_BYTES or sync > 10.0 * FLUSH_SECONDS:
        return warned(f"{finding}: log entries may be dropped", "log to another disk, or raise log.queue")
    return passed(finding)


def kernels(rig: Rig) -> CheckResult:
    """Check that the kernels are compiled for this user and processor."""
    from tendond.model.numerics.compile import uncached
    from tendond.model.rod.rod import Rod

    Rod  # the kernels are known once the rod's module is  # noqa: B018
    missing = uncached()
    folder = os.environ.get(VARIABLE, "")
    if Path(folder).name.startswith(TEMPORARY):
        return warned(
            f"{'not compiled' if missing else 'compiled'}, in {folder}: no other folder is writable",
            f"set {VARIABLE} to a folder of this user's, or kernels are compiled again after each boot",
        )
    if not missing:
        return passed("compiled, for this user and processor")
    return warned(
        f"not compiled for this user: {', '.join(missing)}; the first start takes a minute or two",
        "tendond warm, as the user that runs the controller (deploy/install does it for the service)",
    )


def calibration(rig: Rig) -> CheckResult | None:
    """Check that the calibration is complete, this rig's, and recent."""
    section = rig.config.servo
    if section is None:
        return None
    ids = section.servo_ids(len(rig.config.rod.tendon_positions))
    path = rig.folder / section.calibration
    try:
        found = load_calibration(path, rig.config.rig.name, ids)
        days = (datetime.now(UTC) - datetime.fromisoformat(found.date)).total_seconds() / 86400.0
    except CalibrationError as error:
        what, _, remedy = str(error).rpartition(": ")
        return failed(what, remedy)
    except (ValueError, TypeError):
        return warned(f"{path}: invalid date: {found.date}", "calibrate again: tendond servo calibrate")
    finding = f"{path.name}: {len(ids)} tendons, {days:.0f} days old"
    if days > CALIBRATION_DAYS:
        return warned(f"{finding}; tendons stretch with time", "tendond servo pretension --store")
    return passed(finding)
