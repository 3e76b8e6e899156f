"""Pieces of Markdown, and what docstrings have for them."""

import inspect
import re
from collections.abc import Iterable, Sequence

_ENTRY = re.compile(r"^(\w+(?:, \w+)*): (.*)$")


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Write a table; bars and line ends in cells are escaped."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(_cell(cell) for cell in line) + " |" for line in lines)


def _cell(text: str) -> str:
    return " ".join(text.replace("|", "\\|").split())


def code(text: str) -> str:
    """Format as inline code; an empty text stays empty."""
    return f"`{text}`" if text else ""


def escaped(text: str) -> str:
    """Prose in which a star, an underscore or a bracket means itself."""
    return re.sub(r"([*_])", r"\\\1", text).replace("<", "&lt;")


def summary(thing: object) -> str:
    """Return a docstring up to its lists of arguments and attributes, in one paragraph."""
    text = inspect.getdoc(thing) or ""
    return " ".join(re.split(r"\n(?:Args|Attributes|Raises|Returns):", text)[0].split())


def attributes(thing: object, known: Iterable[str] = ()) -> dict[str, str]:
    """Read each attribute's description from a docstring; of two in a line, 'a: this. b: that.', both if `known`."""
    found = _entries(thing)
    for name in list(found):
        inner = re.split(r"[.;] (\w+(?:, \w+)*): ", found[name])
        for names, text in zip(inner[1::2], inner[2::2], strict=True):
            if set(names.split(", ")) <= set(known):
                found[name] = inner[0] + "."
                found.update(dict.fromkeys(names.split(", "), text))
    return found


def _entries(thing: object) -> dict[str, str]:
    text = inspect.getdoc(thing) or ""
    if "Attributes:" not in text:
        return {}
    found: dict[str, str] = {}
    names: list[str] = []
    for line in text.split("Attributes:\n", 1)[1].splitlines():
        if not line.startswith("    ") or not line.strip():
            break
        if line[4] != " " and (match := _ENTRY.match(line.strip())):
            names = match[1].split(", ")
            found.update(dict.fromkeys(names, match[2]))
        else:
            found.update({name: f"{found[name]} {line.strip()}" for name in names})
    return found
