"""Logs compared with the checksums that were made while they were written."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from tendond.daemon.errors import UsageError
from tendond.daemon.recording.mcap_file import is_being_written
from tendond.daemon.recording.storage.checksum import ChecksumError, checksum, read_checksum, write_checksum

Verdict = Literal["intact", "changed", "no checksum", "being written", "recorded"]


@dataclass(frozen=True)
class Verified:
    """A file and what its checksum says: path, verdict, and a word on it."""

    path: Path
    verdict: Verdict
    remark: str = ""


def verify(path: Path, *, record: bool = False) -> Verified:
    """Compare a file with its checksum.

    Args:
        path: the file.
        record: where there is none, write one of what the file contains now.

    Raises:
        UsageError: the file cannot be read, or the checksum not be written.
    """
    try:
        wanted = read_checksum(path)
        if wanted is None:
            if is_being_written(path):
                return Verified(path, "being written", "its checksum is written as it is closed")
            if not record:
                path.stat()
                return Verified(path, "no checksum", "of an earlier version, or its writer was killed; see --record")
            write_checksum(path, checksum(path))
            return Verified(path, "recorded")
        found = checksum(path)
    except ChecksumError as error:
        return Verified(path, "changed", str(error))
    except OSError as error:
        raise UsageError(f"{error.filename or path}: {error.strerror}; check name and permissions") from error
    if found != wanted:
        return Verified(path, "changed", f"is {found[:12]}..., was {wanted[:12]}... when it was closed")
    return Verified(path, "intact")
