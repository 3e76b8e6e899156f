"""Validation errors as lines for people: key, value, what is allowed, the nearest valid key."""

import difflib
import json
import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from tendond.schemas.errors.keywords import Node, Path, in_range, in_words, node_at, resolved, schema_of, unit_of
from tendond.schemas.errors.units import unit_hint

MEANT = {"reference.target": "name it by position, across, angle or direction"}
"""Keys that people expect and that have several names here."""


@dataclass(frozen=True)
class Objection:
    """One error in data.

    Attributes:
        key: with dots, empty for an error in several keys.
        value: value as text; empty where there is none to show.
        message: the error, and what is allowed.
        path: parts of the key.
        line: line of the file, from 1, where it is known.
    """

    key: str
    value: str
    message: str
    path: Path = ()
    line: int | None = None

    def __str__(self) -> str:
        place = f"{self.key} = {self.value}" if self.key and self.value else self.key
        return f"{place}: {self.message}" if place else self.message


_DOTTED = re.compile(r"[a-z_]+(?:\[\d+])?(?:\.[a-z_0-9]+)+")


def objection_from(message: str) -> Objection:
    """Build an objection from a line of text; a key in the text is its place."""
    match = _DOTTED.search(message)
    return Objection("", "", message, _parts(match[0]) if match else ())


def in_file(objection: Objection, source: str) -> str:
    """Format an objection with file and line: `rig.toml:3: rod.length = -1: must be ...`."""
    return f"{source}{'' if objection.line is None else f':{objection.line}'}: {objection}"


def explain(error: ValidationError, model: Any) -> list[str]:
    """Return one line per error in data for `model`."""
    return [str(objection) for objection in objections(error, model)]


def objections(error: ValidationError, model: Any) -> list[Objection]:
    """List all errors in data for `model`; each line of a validator's text is one objection."""
    root = schema_of(model)
    found = []
    for item in error.errors(include_url=False):
        path = tuple(part for part in item["loc"] if _is_key(part))
        key = dotted(path)
        if item["type"] == "extra_forbidden":
            owner = node_at(root, path[:-1]) or {}
            names = list(resolved(root, owner).get("properties", {}))
            found.append(Objection(key, "", f"unknown key; {MEANT.get(key) or nearest(str(path[-1]), names)}", path))
            continue
        message = item["msg"].removeprefix("Value error, ")
        message = message[:1].lower() + message[1:]
        if item["type"] == "missing" and isinstance(path[-1], int):  # a tuple that is too short
            found.append(Objection(dotted(path[:-1]), _shown(item["input"]), _allowed(root, path[:-1]), path[:-1]))
        elif item["type"] == "missing":
            found.append(Objection(key, "", f"is missing: {_allowed(root, path)}", path))
        elif item["type"] == "value_error":
            value = "" if isinstance(item["input"], dict) else _shown(item["input"])
            found += [
                _within(root, path, key, value, line) if path else objection_from(line) for line in message.splitlines()
            ]
        else:
            allowed = _allowed(root, path)
            found.append(
                Objection(
                    key, _shown(item["input"]), allowed + _hint(root, path, item["input"]) if allowed else message, path
                )
            )
    return found


_INNER = re.compile(r"([a-z_]+(?:\[\d+])?(?:\.[a-z_]+(?:\[\d+])?)*): ")


def _within(root: Node, path: Path, key: str, value: str, line: str) -> Objection:
    """Build an objection of a table's validator; a key of the table at the line's beginning is its place."""
    if not value and (match := _INNER.match(line)):
        parts = _parts(match[1])
        if node_at(root, (*path, *parts)) is not None:
            return Objection(dotted((*path, *parts)), "", line[match.end() :], (*path, *parts))
    return Objection(key, value, line, path)


def _parts(text: str) -> Path:
    """Return the parts of a key with dots and indices: `sensors[0].at`."""
    return tuple(int(part) if part.isdigit() else part for part in re.findall(r"[a-z_][a-z_0-9]*|\d+", text))


def dotted(path: Path) -> str:
    """Write a path with dots and indices: control.laws, rod.gravity[2]."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text


def nearest(wrong: str, names: list[str]) -> str:
    """Suggest the nearest valid name, or list all of them."""
    matches = difflib.get_close_matches(wrong, names, n=1)
    return f"did you mean '{matches[0]}'?" if matches else f"known here: {', '.join(names)}"


def choose(wrong: str, names: Iterable[str]) -> str:
    """List what may be chosen, with the nearest: 'choose one of mpc, sensitivity; did you mean 'sensitivity'?'."""
    known = list(names)
    matches = difflib.get_close_matches(wrong, known, n=1)
    return f"choose one of {', '.join(known)}" + (f"; did you mean '{matches[0]}'?" if matches else "")


def _is_key(part: int | str) -> bool:
    """Return false for names of union branches, which pydantic adds."""
    return isinstance(part, int) or ("[" not in part and part not in {"float", "int", "none"})


def _shown(value: Any) -> str:
    """Write a value as in TOML, shortened."""
    try:
        text = json.dumps(value, ensure_ascii=False)
    except (TypeError, ValueError):
        text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _allowed(root: Node, path: Path) -> str:
    """Return 'must be a number > 0 and <= 10 [m]'; empty where the model does not say."""
    node = node_at(root, path) if path else root
    if node is None:
        return ""
    words = in_words(root, node)
    if words == "a table":
        words = f"a table, [{dotted(path)}]" if path else words
    elif words.endswith("times a table"):
        words = f"tables, each [[{dotted(path)}]]"
    unit = _unit(root, path, node)
    return f"must be {words}{f' [{unit}]' if unit and 'number' in words else ''}"


def _unit(root: Node, path: Path, node: Node) -> str:
    """Return the unit of a value, or that of the list it is in."""
    above = node_at(root, path[:-1]) if path and isinstance(path[-1], int) else None
    return unit_of(root, node) or (unit_of(root, above) if above else "")


def _hint(root: Node, path: Path, value: Any) -> str:
    """Return a hint at another unit, where the value would be in its range with that, or at the nearest word."""
    node = node_at(root, path)
    if node is None:
        return ""
    if isinstance(value, str) and (words := resolved(root, node).get("enum")):
        matches = difflib.get_close_matches(value, [str(word) for word in words], n=1)
        return f"; did you mean '{matches[0]}'?" if matches else ""
    if resolved(root, node).get("type") != "number":
        return ""
    return unit_hint(value, _unit(root, path, node), lambda one: in_range(root, node, one))
