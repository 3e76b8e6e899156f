"""Retention of logs, and the room left for more: a service must not fill a disk silently."""

import re
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

from tendond.daemon.recording.mcap_file import is_being_written
from tendond.daemon.recording.storage.checksum import checksum_path
from tendond.daemon.recording.storage.run_notes import is_tagged, notes_path
from tendond.schemas.config.machine import LogSection

GIGABYTE, MEGABYTE, DAY = 1e9, 1e6, 86400.0
DEFAULT_BYTES, DEFAULT_SHARE = 20.0 * GIGABYTE, 0.1
"""Default size of a service's logs [bytes], or this fraction of the disk where that is less."""

DEFAULT_DAYS = 90.0
RATE_DAYS = 7.0
"""Days over which the growth is measured."""

RATE_SECONDS = 600.0
"""Shortest log that says something about its growth [s]."""

FILES = 10.0
"""Smallest number of files into which the room is divided: only whole files can be removed."""

_NAME = r"-(\d{8}T\d{6}Z)(?:-\d{3,})?\.mcap"


@dataclass(frozen=True)
class Retention:
    """Logs of a rig in a folder, and the bounds of what is kept.

    Attributes:
        folder: folder of the logs.
        rig: whose logs, by their names, RIG-TIME.mcap as `tendond run` gives them; others are not touched.
        size: bound of all together [bytes]. age: bound of a newest entry's age [s]. None: without a bound.
    """

    folder: Path
    rig: str
    size: float | None
    age: float | None

    @property
    def is_bounded(self) -> bool:
        """True if anything is ever removed."""
        return self.size is not None or self.age is not None

    def split_bytes(self, configured: float) -> float:
        """Size from which on a run goes on in another file [bytes]."""
        return configured if self.size is None else min(configured, self.size / FILES)

    def prune(self, reserve: float, keep: Path | None = None) -> list[Path]:
        """Remove what is too old, then the oldest until a new file of `reserve` bytes fits; return the files removed.

        Args:
            reserve: room that is wanted [bytes].
            keep: is not removed, whatever it is.
        """
        removed = [one.path for one in self._walk(reserve, keep, _remove)]
        left = {self.run_of(path) for path, _, _ in self.files()}
        for run in {self.run_of(path) for path in removed} - left:
            with suppress(OSError):  # notes of a run of which nothing is left
                notes_path(self.folder, run).unlink(missing_ok=True)
        return removed

    def plan(self, reserve: float = 0.0) -> list["Removal"]:
        """Return what `prune` would remove, and why; nothing is removed."""
        return list(self._walk(reserve, None, lambda path: True))

    def _walk(self, reserve: float, keep: Path | None, remove: Callable[[Path], bool]) -> Iterator["Removal"]:
        """Yield what is removed, the oldest first; never a file that is being written, nor one of a run with a tag."""
        files = list(self.files())
        now = time.time()
        used = sum(size for _, size, _ in files)
        room = None if self.size is None else min(self.size, used + shutil.disk_usage(self.folder).free) - reserve
        for path, size, changed in files:
            too_old = self.age is not None and now - changed > self.age
            if path == keep or not (too_old or (room is not None and used > room)):
                continue
            if is_tagged(notes_path(self.folder, self.run_of(path))) or is_being_written(path) or not remove(path):
                continue
            used -= size
            yield Removal(path, size, "age" if too_old else "size", (now - changed) / DAY)

    def run_of(self, path: Path) -> str:
        """Return the name of the run of one of `files`."""
        match = re.fullmatch(re.escape(self.rig) + _NAME, path.name)
        return path.stem if match is None else f"{self.rig}-{match[1]}"

    def files(self) -> Iterator[tuple[Path, int, float]]:
        """Path, size [bytes] and time of the last change [s, wall clock] of each log of the rig, the oldest first."""
        found = []
        pattern = re.compile(re.escape(self.rig) + _NAME)
        for path in self.folder.glob(f"{self.rig}-*.mcap"):
            if pattern.fullmatch(path.name):
                with suppress(OSError):  # gone meanwhile
                    status = path.stat()
                    found.append((path, status.st_size, status.st_mtime))
        yield from sorted(found, key=lambda one: (one[2], one[0]))

    def disk_space(self) -> "DiskSpace":
        """Return the space there is, and for how long."""
        now = time.time()
        files = list(self.files())
        used = float(sum(size for _, size, _ in files))
        free = float(shutil.disk_usage(self.folder).free)
        left = free if self.size is None else max(0.0, min(self.size - used, free))
        recent = [one for one in files if now - one[2] < RATE_DAYS * DAY]
        begun = min((_begun(path, self.rig, changed) for path, _, changed in recent), default=now)
        span = min(now - begun, RATE_DAYS * DAY)
        rate = sum(size for _, size, _ in recent) / span * DAY if span > RATE_SECONDS else None
        return DiskSpace(used, free, self.size, rate, left / rate if rate else None)


@dataclass(frozen=True)
class Removal:
    """A file that retention removes.

    Attributes:
        path: the file. size: its size [bytes].
        reason: which bound it is beyond.
        days: age of its newest entry [days].
    """

    path: Path
    size: int
    reason: Literal["age", "size"]
    days: float


def _remove(path: Path) -> bool:
    """Remove a log with what stands beside it; return whether it is gone."""
    try:
        path.unlink()
    except OSError:  # somebody else's: it stays
        return False
    with suppress(OSError):
        checksum_path(path).unlink(missing_ok=True)
    return True


@dataclass(frozen=True)
class DiskSpace:
    """Space for logs on the disk.

    Attributes:
        used: size of the rig's logs; free: space on the disk; size: bound of the logs [bytes]; None: without a bound.
        rate: growth in the last days [bytes a day]; none where that is not known yet.
        days: until it is used up at that rate; none likewise.
    """

    used: float
    free: float
    size: float | None
    rate: float | None
    days: float | None


def retention(section: LogSection, folder: Path, rig: str, *, service: bool) -> Retention:
    """Read [log] for a folder.

    Args:
        section: [log].
        folder: folder of the logs.
        rig: whose.
        service: whether it is that of a service, whose logs nobody tidies up: both bounds have a default then.
    """
    size = None if section.keep_size is None else section.keep_size * GIGABYTE
    days = section.keep_days
    if service:
        if size is None:
            size = min(DEFAULT_BYTES, DEFAULT_SHARE * shutil.disk_usage(existing(folder)).total)
        days = DEFAULT_DAYS if days is None else days
    return Retention(folder, rig, size or None, days * DAY if days else None)


def existing(folder: Path) -> Path:
    """Return the folder, or the nearest one above it that exists."""
    folder = folder.absolute()
    while not folder.exists():
        folder = folder.parent
    return folder


def _begun(path: Path, rig: str, changed: float) -> float:
    """Return the time at which the run of a file began, by its name [s, wall clock]."""
    match = re.fullmatch(re.escape(rig) + _NAME, path.name)
    with suppress(ValueError):
        if match is not None:
            return datetime.strptime(match[1], "%Y%m%dT%H%M%SZ").replace(tzinfo=UTC).timestamp()
    return changed
