"""Files of results, and names of files."""

import os
from pathlib import Path


def write_whole(path: Path, text: str) -> None:
    """Write a file atomically: it exists whole or not at all."""
    draft = path.with_name(path.name + ".part")
    draft.write_text(text, encoding="utf-8")
    os.replace(draft, path)


def as_text(name: str) -> str:
    """Decode a file's name for printing, with replacements where it is not UTF-8."""
    return os.fsencode(name).decode("utf-8", errors="replace")
