"""Tags and notes of a run: a file beside its logs, which themselves are never changed."""

import os
from pathlib import Path
from typing import Literal

from pydantic import Field, ValidationError

from tendond.schemas.base import SCHEMA_VERSION, Schema

SUFFIX = ".notes.json"
"""Added to the name of a run: of run.mcap, run-001.mcap, ... it is run.notes.json."""

TAG = r"^[a-z0-9][a-z0-9_-]{0,31}$"


class RunNotesError(ValueError):
    """A file of tags and notes that cannot be read."""


class Note(Schema):
    """A note on a run.

    Attributes:
        time: UTC, ISO 8601. text: what someone wrote.
    """

    time: str
    text: str


class RunNotes(Schema):
    """Tags and notes of a run."""

    version: Literal[1] = SCHEMA_VERSION
    tags: tuple[str, ...] = Field((), max_length=100)
    notes: tuple[Note, ...] = Field((), max_length=10000)


def notes_path(folder: Path, run: str) -> Path:
    """Return the path of a run's tags and notes; `run` is the name of its first file without `.mcap`."""
    return folder / f"{run}{SUFFIX}"


def read_notes(path: Path) -> RunNotes:
    """Read tags and notes; empty where there is no file.

    Raises:
        RunNotesError: the file is damaged, or of another version. OSError: it cannot be read.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return RunNotes()
    except UnicodeDecodeError as error:
        raise RunNotesError(f"{path}: is not text in UTF-8: repair or remove it") from error
    try:
        return RunNotes.model_validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ": ".join([str(path), *(str(part) for part in first["loc"])])
        raise RunNotesError(f"{where}: {first['msg']}; repair the file, or upgrade tendond") from error


def write_notes(path: Path, notes: RunNotes) -> None:
    """Write tags and notes atomically; without any there is no file.

    Raises:
        OSError: it cannot be written.
    """
    if not notes.tags and not notes.notes:
        path.unlink(missing_ok=True)
        return
    draft = path.with_name(f"{path.name}.part")
    draft.write_text(notes.model_dump_json(indent=2) + "\n", encoding="utf-8")
    os.replace(draft, path)


def is_tagged(path: Path) -> bool:
    """Return whether a run has a tag, and is kept for that; a damaged file counts as one."""
    try:
        return bool(read_notes(path).tags)
    except (OSError, RunNotesError):
        return True
