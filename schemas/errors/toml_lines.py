"""Line numbers of the keys of a TOML text, for messages: tomllib does not report them."""

import re
from collections.abc import Mapping

from tendond.schemas.errors.keywords import Path

_PART = r"""(?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*')"""
_NAME = rf"{_PART}(?:\s*\.\s*{_PART})*"
_HEADER = re.compile(rf"\s*(\[\[?)\s*({_NAME})\s*]]?\s*(?:#.*)?$")
_KEY = re.compile(rf"\s*({_NAME})\s*=")
_PLACE = re.compile(r"at line (\d+)")
_COMMA = re.compile(r"=\s*([-+]?\d+),(\d+)")
_STRING_OR_COMMENT = re.compile(r"""\"(?:\\.|[^"\\])*"|'[^']*'|#.*""")


def not_toml(text: str, error: Exception) -> str:
    """Return the message of a text that is not TOML, with a hint at a decimal comma in the line of the error."""
    hint = ""
    if place := _PLACE.search(str(error)):
        line = text.splitlines()[int(place[1]) - 1 :][:1]
        if line and (number := _COMMA.search(line[0])):
            hint = f"; a decimal has a point: {number[1]}.{number[2]}"
    return f"is not valid TOML: {error}{hint}"


def key_lines(text: str) -> dict[Path, int]:
    """Find the line, from 1, of each table and key of a TOML text; tables of a list have their index in the path.

    Keys inside inline tables are not found, nor those after a string of several lines that holds brackets.
    """
    lines: dict[Path, int] = {}
    counts: dict[Path, int] = {}
    table: Path = ()
    depth = 0
    for number, line in enumerate(text.splitlines(), 1):
        if depth == 0 and (header := _HEADER.match(line)):
            table = _parts(header[2])
            if header[1] == "[[":
                counts[table] = counts.get(table, -1) + 1
                lines.setdefault(table, number)
                table = (*table, counts[table])
            elif table[:1] and (parent := table[:-1]) in counts:
                table = (*parent, counts[parent], table[-1])
            lines.setdefault(table, number)
            continue
        if depth == 0 and (key := _KEY.match(line)):
            lines.setdefault((*table, *_parts(key[1])), number)
        bare = _STRING_OR_COMMENT.sub("", line)
        depth = max(0, depth + bare.count("[") - bare.count("]"))
    return lines


def line_of(path: Path, lines: Mapping[Path, int]) -> int | None:
    """Return the line of a key, or of the innermost table around it that has one."""
    while path and path not in lines:
        path = path[:-1]
    return lines.get(path)


def _parts(name: str) -> Path:
    return tuple(part.strip("\"'") for part in re.findall(_PART, name))
