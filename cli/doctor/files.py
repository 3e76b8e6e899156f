"""Checks of what lies on the disk: logs, kernels, the calibration."""

import os
import tempfile
import time
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from tendond.cli.doctor.check import Result, Rig, bad, doubtful, good
from tendond.cli.kernel_folder import TEMPORARY, VARIABLE
from tendond.daemon.recording.recorder import FLUSH_SECONDS
from tendond.daemon.recording.retention import GIGABYTE, MEGABYTE, existing, retention
from tendond.drivers.dynamixel.calibration import CalibrationError, load_calibration

TRIAL_BYTES, BLOCK_BYTES = 8_000_000, 128_000
SLOW_BYTES = 5e6
"""[bytes/s]; a log of every cycle at 100 Hz takes a tenth of it."""

FILES_LEFT = 10
"""Files of log.split_size, below which the disk is nearly full."""

CALIBRATION_DAYS = 30.0
SYSTEM_LOGS = Path("/var/log/tendond")
"""Of services, whose logs are bounded by default."""


FEW_DAYS = 7.0
"""Of room, from which on somebody should think about it where nothing is removed by itself."""


def log_space(rig: Rig) -> Result:
    """Room for logs, and how long it lasts at the rate of the last days."""
    folder = existing(rig.log_folder)
    name, section = rig.config.rig.name, rig.config.log
    kept = retention(section, rig.log_folder, name, service=rig.log_folder.resolve().is_relative_to(SYSTEM_LOGS))
    room = replace(kept, folder=folder).room()
    finding = f"{room.free / GIGABYTE:.1f} GB free for {rig.log_folder}, {room.used / GIGABYTE:.1f} GB of logs"
    if room.size is not None:
        finding += f" of {room.size / GIGABYTE:.1f} GB that may be kept"
    if room.rate is not None and room.days is not None:
        then = "the oldest are removed" if kept.size is not None else "the disk is full"
        finding += f"; at {room.rate / GIGABYTE:.2f} GB a day {then} in {room.days:.1f} days"
    size = kept.split_bytes(section.split_size * MEGABYTE)
    if room.free < size:
        return bad(f"{finding}; less than one file of log.split_size", "remove old logs, or log to another disk")
    if room.free < FILES_LEFT * size:
        return doubtful(f"{finding}; fewer than {FILES_LEFT} files of log.split_size", "remove old logs soon")
    if kept.size is None and room.days is not None and room.days < FEW_DAYS:
        return doubtful(finding, "set log.keep_size, or remove old logs soon")
    return good(finding)


def log_speed(rig: Rig) -> Result:
    """Whether the disk keeps up with the recorder: some megabytes are written, handed to the disk, and removed."""
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
        return doubtful(
            f"{folder}: not tried: {error.strerror}",
            f"run it as the user that logs: sudo -u tendond tendond doctor ({folder})",
        )
    speed, sync = TRIAL_BYTES / (ended - started), ended - before
    finding = f"{speed / 1e6:.0f} MB/s, {sync * 1e3:.0f} ms to hand {TRIAL_BYTES / 1e6:g} MB to the disk"
    if speed < SLOW_BYTES or sync > 10.0 * FLUSH_SECONDS:
        return doubtful(f"{finding}: log entries may be dropped", "log to another disk, or raise log.queue")
    return good(finding)


def kernels(rig: Rig) -> Result:
    """Whether the model's kernels are compiled for this user and this processor."""
    from tendond.model.numerics.compile import uncached
    from tendond.model.rod.rod import Rod

    Rod  # the kernels are known once the rod's module is  # noqa: B018
    missing = uncached()
    folder = os.environ.get(VARIABLE, "")
    if Path(folder).name.startswith(TEMPORARY):
        return doubtful(
            f"{'not compiled' if missing else 'compiled'}, in {folder}: no other folder can be written",
            f"set {VARIABLE} to a folder of this user's, or compiling starts anew with each boot",
        )
    if not missing:
        return good("compiled, for this user and processor")
    return doubtful(
        f"not compiled for this user: {', '.join(missing)}; the first start takes a minute or two",
        "python -m tendond.model.warm, as the user that runs the controller (deploy/install does it for the service)",
    )


def calibration(rig: Rig) -> Result | None:
    """Of the servos: there, this rig's, whole, and not old."""
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
        return bad(what, remedy)
    except (ValueError, TypeError):
        return doubtful(f"{path}: its date is none: {found.date}", "calibrate anew: tendond servo calibrate")
    finding = f"{path.name}: {len(ids)} tendons, {days:.0f} days old"
    if days > CALIBRATION_DAYS:
        return doubtful(f"{finding}; tendons stretch with time", "tendond servo pretension --store")
    return good(finding)
