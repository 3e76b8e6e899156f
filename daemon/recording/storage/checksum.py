"""Checksum of a log: made while it is written, kept beside it in the form of sha256sum."""

import hashlib
from pathlib import Path
from typing import BinaryIO

SUFFIX = ".sha256"
"""Added to a file's name: run.mcap.sha256; `sha256sum --check` reads it as well."""

_BLOCK = 1 << 20


class ChecksumError(ValueError):
    """A file of a checksum that has none."""


class HashedStream:
    """A file that is written from its beginning to its end, and hashed on the way: it need not be read again."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self._hash = hashlib.sha256()

    @property
    def digest(self) -> str:
        """SHA-256 of what has been written, in hexadecimal digits."""
        return self._hash.hexdigest()

    def write(self, data: bytes) -> int:
        """Write; the whole of it, or it raises."""
        self._hash.update(data)
        return self._stream.write(data)

    def tell(self) -> int:
        """Return the number of bytes written."""
        return self._stream.tell()

    def fileno(self) -> int:
        """Return the descriptor of the file."""
        return self._stream.fileno()

    def flush(self) -> None:
        """Hand everything to the kernel."""
        self._stream.flush()

    def close(self) -> None:
        """Close the file."""
        self._stream.close()


def checksum_path(path: Path) -> Path:
    """Return the path of a file's checksum."""
    return path.with_name(path.name + SUFFIX)


def write_checksum(path: Path, digest: str) -> None:
    """Write the checksum of a file beside it.

    Raises:
        OSError: it cannot be written.
    """
    checksum_path(path).write_text(f"{digest}  {path.name}\n", encoding="utf-8")


def read_checksum(path: Path) -> str | None:
    """Read the checksum of a file; none where there is none.

    Raises:
        ChecksumError: there is a file, but no checksum in it. OSError: it cannot be read.
    """
    try:
        words = checksum_path(path).read_text(encoding="utf-8", errors="replace").split()
    except FileNotFoundError:
        return None
    if not words or len(words[0]) != 64 or set(words[0].lower()) - set("0123456789abcdef"):
        raise ChecksumError(f"{checksum_path(path)}: is not the checksum of a file")
    return words[0].lower()


def checksum(path: Path) -> str:
    """Compute the checksum of a file.

    Raises:
        OSError: it cannot be read.
    """
    found = hashlib.sha256()
    with path.open("rb") as stream:
        while block := stream.read(_BLOCK):
            found.update(block)
    return found.hexdigest()
