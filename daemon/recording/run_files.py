"""The files of a run: one MCAP file, or several in a row, each of which stands alone."""

from collections.abc import Callable
from pathlib import Path

from tendond.daemon.recording.mcap_file import McapFile

CONFIG = "rig.json"
"""Name of the attachment that holds the configuration, so that the file replays on its own."""

CALIBRATION = "calibration.json"
"""Name of the attachment that holds the calibration of the servos, where the rig has one."""

PART = "part"
"""Name in the metadata of the number of a file in its run, from 0."""


FORMAT = "format"
"""Name in the metadata of the version of the log; logs of versions 1 and 2 may have none."""

LOG_FORMAT = 2
"""Version of what a log contains. Version 1: states have the fields that `daemon/control/renamed.py` names.

Logs of every version before are read as they are. Raised by a change that an older tendond would misread.
"""


def part_path(path: Path, part: int) -> Path:
    """Return the path of a further file of the run whose first is `path`."""
    return path.with_name(f"{path.stem}-{part:03d}{path.suffix}")


def run_name(path: Path, part: int) -> str:
    """Return the name of the run of a file: that of its first file, without `.mcap`."""
    return path.stem if part == 0 else path.stem.removesuffix(f"-{part:03d}")


class RunFiles:
    """Files of a run, the last of which is being written.

    Args:
        path: path of the first file; an existing one is refused: a log is never overwritten.
        metadata, attachments: in each file, beside the number of the part.
        split_bytes, split_seconds: size and age from which on the run goes on in another file, `run-001.mcap` after
            `run.mcap`.
        before_file: called with the path of a file before it is begun.
    """

    def __init__(
        self,
        path: Path,
        metadata: dict[str, str],
        attachments: dict[str, str],
        split_bytes: float,
        split_seconds: float,
        before_file: Callable[[Path], None] | None,
    ) -> None:
        self._path = path
        self._metadata = metadata
        self._attachments = attachments
        self._split_bytes = split_bytes
        self._split_seconds = split_seconds
        self._before_file = before_file
        self._part = 0

    def open(self) -> None:
        """Begin the first file, and its folder where there is none.

        Raises:
            OSError: it cannot be written.
        """
        self._path.parent.mkdir(parents=True, exist_ok=True)
        self._begin()

    def _begin(self) -> None:
        path = self._path if self._part == 0 else part_path(self._path, self._part)
        if self._before_file is not None:
            self._before_file(path)
        self._file = McapFile(path, {**self._metadata, PART: str(self._part)}, self._attachments)

    @property
    def is_full(self) -> bool:
        """True if the run should go on in another file."""
        return self._file.size >= self._split_bytes or self._file.age >= self._split_seconds

    def begin_next(self) -> None:
        """Begin the next file, after the one before it is finished.

        Raises:
            OSError: it cannot be written.
        """
        self._part += 1
        self._begin()

    def write(self, topic: str, time_ns: int, data: bytes) -> None:
        """Add a message to the file."""
        self._file.write(topic, time_ns, data)

    def flush(self) -> None:
        """Hand everything to the kernel: a kill cannot undo it, a power cut can."""
        self._file.flush()

    def finish(self) -> None:
        """Write the summary and the end of the file."""
        self._file.finish()

    def abandon(self) -> None:
        """Close the file as it is."""
        self._file.abandon()
