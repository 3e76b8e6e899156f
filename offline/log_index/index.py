"""The runs of a folder, from its logs and what stands beside them; a file of what was found spares reading them again.

The index can be removed at any time: it is made anew. Tags, notes and checksums are in files of their own.
"""

import json
from collections import defaultdict
from collections.abc import Callable, Collection
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from tendond.daemon.errors import UsageError
from tendond.daemon.recording.storage.run_notes import Note, RunNotesError, notes_path, read_notes
from tendond.offline.files import write_whole
from tendond.offline.log_index.scan import ScannedFile, scan

INDEX = ".tendond-index.json"
INDEX_VERSION = 1


@dataclass(frozen=True)
class RunEntry:
    """A run in a folder.

    Attributes:
        run: name of its first file without `.mcap`.
        files: names of its files, in their order.
        bytes: size of all together.
        rig, law, reference: of its configuration.
        started: UTC, ISO 8601; empty without entries. duration_s: first to last entry [s].
        cycles: number of cycles in its files.
        faults: reason of each fault.
        complete: the last file was finished.
        problem: why a file cannot be read; empty otherwise.
        tags, notes: what someone wrote; see `tendond log tag` and `log note`.
    """

    run: str
    files: tuple[str, ...]
    bytes: int
    rig: str = ""
    law: str = ""
    reference: str = ""
    started: str = ""
    duration_s: float = 0.0
    cycles: int = 0
    faults: tuple[str, ...] = ()
    complete: bool = False
    problem: str = ""
    tags: tuple[str, ...] = ()
    notes: tuple[Note, ...] = field(default=())

    def as_json(self) -> dict[str, Any]:
        """Return the fields in JSON types."""
        return {**asdict(self), "notes": [note.model_dump() for note in self.notes]}

    def matches(self, tags: Collection[str], text: str) -> bool:
        """Return whether the run has all tags, and the text, in any case, in anything that is listed of it."""
        said = [self.run, self.rig, self.law, self.reference, self.started, self.problem, *self.faults, *self.tags]
        said += [note.text for note in self.notes]
        return set(tags) <= set(self.tags) and any(text.casefold() in one.casefold() for one in said)


def list_runs(folder: Path, watch: Callable[[int, int], None] = lambda done, count: None) -> list[RunEntry]:
    """List the runs of a folder, the oldest first.

    Args:
        folder: where the logs are; folders in it are not searched.
        watch: called with the files read so far, and their number.

    Raises:
        UsageError: the folder cannot be read.
    """
    try:
        paths = sorted(path for path in folder.iterdir() if path.suffix == ".mcap" and path.is_file())
    except OSError as error:
        raise UsageError(f"{folder}: cannot be read: {error.strerror}; give the folder of the logs") from error
    known = _load(folder)
    files: dict[Path, tuple[ScannedFile, int]] = {}
    kept: dict[str, Any] = {}
    for number, path in enumerate(paths):
        watch(number, len(paths))
        with suppress(OSError):  # gone meanwhile
            status = path.stat()
            stamp = [status.st_size, status.st_mtime_ns]
            before = known.get(path.name)
            found = _scanned(before["file"]) if before and before["stamp"] == stamp else None
            found = found or scan(path)
            files[path] = found, status.st_size
            kept[path.name] = {"stamp": stamp, "file": asdict(found)}
    if kept != known:
        with suppress(OSError):  # a folder of the service's: it is listed all the same
            write_whole(folder / INDEX, json.dumps({"version": INDEX_VERSION, "files": kept}) + "\n")
    watch(len(paths), len(paths))
    return _runs(folder, files)


def _runs(folder: Path, files: dict[Path, tuple[ScannedFile, int]]) -> list[RunEntry]:
    """Join the files of each run."""
    parts: dict[str, list[tuple[Path, ScannedFile, int]]] = defaultdict(list)
    for path, (found, size) in files.items():
        parts[found.run].append((path, found, size))
    entries = [_entry(folder, run, sorted(some, key=lambda one: one[1].part)) for run, some in parts.items()]
    return sorted(entries, key=lambda one: (one.started, one.run))


def _entry(folder: Path, run: str, parts: list[tuple[Path, ScannedFile, int]]) -> RunEntry:
    files = [found for _, found, _ in parts]
    begun = min((one.begun for one in files if one.begun), default=0)
    ended = max((one.ended for one in files), default=0)
    problem = next((one.problem for one in files if one.problem), "")
    tags: tuple[str, ...] = ()
    notes: tuple[Note, ...] = ()
    try:
        written = read_notes(notes_path(folder, run))
        tags, notes = written.tags, written.notes
    except (RunNotesError, OSError) as error:
        problem = problem or str(error)
    readable = next((one for one in files if not one.problem), files[0])
    return RunEntry(
        run=run,
        files=tuple(path.name for path, _, _ in parts),
        bytes=sum(size for _, _, size in parts),
        rig=readable.rig,
        law=readable.law,
        reference=readable.reference,
        started=datetime.fromtimestamp(begun / 1e9, UTC).isoformat(timespec="seconds") if begun else "",
        duration_s=round((ended - begun) / 1e9, 3) if begun else 0.0,
        cycles=sum(one.cycles for one in files),
        faults=tuple(reason for one in files for reason in one.faults),
        complete=files[-1].complete,
        problem=problem,
        tags=tags,
        notes=notes,
    )


def _load(folder: Path) -> dict[str, Any]:
    """Read the index; nothing where there is none, or one that is not of this version."""
    with suppress(OSError, ValueError):
        data = json.loads((folder / INDEX).read_text(encoding="utf-8"))
        if isinstance(data, dict) and data.get("version") == INDEX_VERSION and isinstance(data.get("files"), dict):
            files: dict[str, Any] = data["files"]
            return {name: one for name, one in files.items() if isinstance(one, dict) and {"stamp", "file"} <= set(one)}
    return {}


def _scanned(values: Any) -> ScannedFile | None:
    """Read an entry of the index; none where it is not one."""
    try:
        return ScannedFile(**{**values, "faults": tuple(values["faults"])})
    except (TypeError, KeyError):
        return None
