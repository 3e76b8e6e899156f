"""An MCAP file of a log: metadata, attachments and channels first, then messages, flushed when asked."""

import fcntl
import importlib.util
import time
from contextlib import suppress
from pathlib import Path
from typing import IO, cast

from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import CompressionType, Writer

from tendond.daemon.recording.channels import CHANNELS
from tendond.daemon.recording.storage.checksum import HashedStream, checksum_path, write_checksum

METADATA = "tendond"
"""Name of the metadata record that makes an MCAP file one of our logs."""

CHUNK_BYTES = 128 * 1024


class McapFile:
    """The MCAP file. After the first error mcap's writer holds half a chunk and must not be used again."""

    def __init__(self, path: Path, metadata: dict[str, str], attachments: dict[str, str]) -> None:
        self._begun = time.monotonic()
        self._path = path
        self._stream = HashedStream(path.open("xb"))
        self._writer = Writer(cast(IO[bytes], self._stream), chunk_size=CHUNK_BYTES, compression=_compression())
        try:
            with suppress(OSError):  # a file system without locks
                fcntl.flock(self._stream.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
            checksum_path(path).unlink(missing_ok=True)  # of a log of that name before
            self._begin(metadata, attachments)
        except OSError:
            self.abandon()
            raise

    def _begin(self, metadata: dict[str, str], attachments: dict[str, str]) -> None:
        self._writer.start()
        self._writer.add_metadata(METADATA, metadata)
        now_ns = time.time_ns()
        for name, text in attachments.items():
            media_type = "application/json" if name.endswith(".json") else "text/plain"
            self._writer.add_attachment(now_ns, now_ns, name, media_type, text.encode())
        # Channels now: their schemas take milliseconds, which the control loop would feel later.
        self._channels: dict[str, int] = {}
        for channel in CHANNELS:
            schema = self._writer.register_schema(channel.schema_name, SchemaEncoding.JSONSchema, channel.schema())
            self._channels[channel.topic] = self._writer.register_channel(channel.topic, MessageEncoding.JSON, schema)
        self.flush()

    @property
    def size(self) -> int:
        """Size on the disk, without the chunk in progress [bytes]."""
        return self._stream.tell()

    @property
    def age(self) -> float:
        """Time since the file was opened [s]."""
        return time.monotonic() - self._begun

    def write(self, topic: str, time_ns: int, data: bytes) -> None:
        """Add a message to the chunk in progress, which goes to the disk when it is full."""
        self._writer.add_message(self._channels[topic], time_ns, data, publish_time=time_ns)

    def flush(self) -> None:
        """Close the chunk in progress and hand everything to the kernel: a kill cannot undo it, a power cut can."""
        self._writer.flush()

    def finish(self) -> None:
        """Write summary and end, and the checksum beside the file."""
        self._writer.finish()
        self._stream.close()
        with suppress(OSError):  # a disk that is full now: the log itself is whole
            write_checksum(self._path, self._stream.digest)

    def abandon(self) -> None:
        """Close as it is."""
        with suppress(OSError):  # it tries to write what it still holds, which fails again, and closes all the same
            self._stream.close()


def is_being_written(path: Path) -> bool:
    """Return whether a process is writing the file."""
    try:
        with path.open("rb") as stream:
            fcntl.flock(stream, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:  # gone, someone else's, or a file system without locks
        return False
    return False


def _compression() -> CompressionType:
    """The best that is installed."""
    if importlib.util.find_spec("zstandard"):
        return CompressionType.ZSTD
    return CompressionType.LZ4 if importlib.util.find_spec("lz4") else CompressionType.NONE


def reason_of(error: Exception) -> str:
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return f"{type(error).__name__}: {error}".splitlines()[0]
