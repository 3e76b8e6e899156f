"""Files of results, and names of files."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Yield a draft beside a file, which replaces it at the end: the file exists whole, or as it was before.

    The draft has the file's ending, by which some writers choose the format. What is no regular file, such as
    /dev/stdout, is written itself.

    Raises:
        OSError: with the file's name, also where a writer's own error has none, such as that of a full disk.
    """
    if path.is_symlink():
        path = path.resolve()
    if path.exists() and not path.is_file():
        with _named(path):
            yield path
        return
    draft = path.with_name(f".{path.stem}.part{path.suffix}")
    try:
        with _named(path):
            yield draft
            os.replace(draft, path)
    finally:
        with suppress(OSError):
            draft.unlink()


@contextmanager
def _named(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(path)) from error


def write_whole(path: Path, text: str) -> None:
    """Write a text file atomically, see `whole`."""
    with whole(path) as draft:
        draft.write_text(text, encoding="utf-8")


def free_folder(folder: Path) -> Path:
    """Return the folder, or the first with a number behind its name that does not exist."""
    found, number = folder, 1
    while found.exists():
        number += 1
        found = folder.with_name(f"{folder.name}-{number}")
    return found


def as_text(name: str) -> str:
    """Decode a file's name for printing, with replacements where it is not UTF-8."""
    return os.fsencode(name).decode("utf-8", errors="replace")
