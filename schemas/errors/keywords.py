"""Allowed values of a key in words, from the JSON Schema that pydantic makes of a model."""

import json
import re
from dataclasses import dataclass
from functools import cache
from typing import Any

from pydantic import TypeAdapter

Node = dict[str, Any]
"""Node of a JSON Schema."""

Path = tuple[int | str, ...]
"""Keys and indices from the model down to a value."""

WORDS = "x-words"
"""Key of a JSON Schema's node that says its allowed values itself."""

_BOUNDS = (("exclusiveMinimum", ">"), ("minimum", ">="), ("exclusiveMaximum", "<"), ("maximum", "<="))
_UNIT = re.compile(r"^\[([^]]+)]|\[([^]]+)](?=;|$)")


@cache
def schema_of(model: Any) -> Node:
    """Return the JSON Schema of a type: a model, a dataclass, or any other that pydantic can validate."""
    return TypeAdapter(model).json_schema()


@dataclass(frozen=True)
class Key:
    """A key of a model, for people.

    Attributes:
        path: with dots; `[]` stands for each table of a list.
        words: allowed values: 'a number > 0 and <= 10'.
        unit: SI, '-' for a pure number, empty for what has none.
        default: default as in JSON; none for a required key, or an optional one without a default.
        required: it must be given.
        meaning: description without the unit.
    """

    path: str
    words: str
    unit: str
    default: Any
    required: bool
    meaning: str

    @property
    def name(self) -> str:
        """Name without its table's."""
        return self.path.rsplit(".", 1)[-1]


@dataclass(frozen=True)
class Table:
    """A table of a model: its name with dots, what it is, its keys in their order, and whether it is optional."""

    name: str
    meaning: str
    keys: tuple[Key, ...]
    optional: bool = False


def tables(model: Any) -> list[Table]:
    """List the tables of a configuration's model in the order of its fields, each followed by its own tables."""
    root = schema_of(model)
    found: list[Table] = []
    for name, node in root["properties"].items():
        each = resolved(root, node).get("items")
        _collect(root, name if each is None else f"{name}[]", each or node, found)
    return found


def keys_of(model: Any) -> tuple[Key, ...]:
    """List the keys of a model without tables, such as a law's parameters."""
    root = schema_of(model)
    required = root.get("required", ())
    return tuple(_key(root, name, node, required=name in required) for name, node in root["properties"].items())


def _collect(root: Node, name: str, node: Node, found: list[Table]) -> None:
    place = len(found)
    keys = []
    table = resolved(root, node)
    for key, inner in table["properties"].items():
        below = resolved(root, inner)
        each = resolved(root, below.get("items", {}))
        if "properties" in below:
            _collect(root, f"{name}.{key}", inner, found)
        elif "properties" in each:
            _collect(root, f"{name}.{key}[]", below["items"], found)
        else:
            keys.append(_key(root, f"{name}.{key}", inner, required=key in table.get("required", ())))
    said = " ".join(table.get("description", "").partition("\n\n")[0].split())
    meaning = re.sub(r"^\[\[?[^:]*]\]?(: )?", "", said).rstrip(".")
    optional = node.get("default", 0) is None or name.endswith("[]")
    found.insert(place, Table(name, meaning, tuple(keys), optional))


def _key(root: Node, path: str, node: Node, *, required: bool) -> Key:
    described = node if "description" in node else resolved(root, node)
    text = described.get("description", "")
    unit = unit_of(root, node)
    meaning = re.sub(r" ?\[" + re.escape(unit) + r"](?=;|$)", "", text, count=1).strip(" ;") if unit else text
    return Key(path, in_words(root, node), unit, node.get("default"), required, meaning)


def unit_of(root: Node, node: Node) -> str:
    """Return the unit in brackets at the start, at the end or before a semicolon of a description, or nothing."""
    inner = resolved(root, node)
    match = _UNIT.search(node.get("description") or inner.get("description") or "")
    return (match[1] or match[2]) if match and inner.get("type") in {"number", "integer", "array"} else ""


def resolved(root: Node, node: Node) -> Node:
    """Return the node itself, behind references and 'or none'."""
    while True:
        if "$ref" in node:
            node = root["$defs"][node["$ref"].rsplit("/", 1)[-1]]
        elif "anyOf" in node:
            node = next(branch for branch in node["anyOf"] if branch.get("type") != "null")
        else:
            return node


def node_at(root: Node, path: Path) -> Node | None:
    """Return the node of a value; none where the model has no such place."""
    node = root
    for part in path:
        inner = resolved(root, node)
        if isinstance(part, int):
            fixed = inner.get("prefixItems", ())
            node = fixed[part] if part < len(fixed) else inner.get("items", {})
        elif part in inner.get("properties", {}):
            node = inner["properties"][part]
        elif isinstance(inner.get("additionalProperties"), dict):
            node = inner["additionalProperties"]
        else:
            return None
    return node


def in_words(root: Node, node: Node) -> str:
    """Describe the allowed values: 'a number > 0 and <= 10', 'one of "xz", "yz"', '3 numbers'."""
    for branch in (node, *node.get("anyOf", ())):
        if WORDS in branch:
            return str(branch[WORDS])
    node = resolved(root, node)
    if "const" in node:
        return json.dumps(node["const"])
    if "enum" in node:
        return "one of " + ", ".join(json.dumps(value) for value in node["enum"])
    match node.get("type"):
        case "number" | "integer":
            kind = "a number" if node["type"] == "number" else "a whole number"
            return f"{kind} {bounds}" if (bounds := _bounds(node)) else kind
        case "string":
            return "a text"
        case "boolean":
            return "true or false"
        case "array":
            return _array_in_words(root, node)
        case "object":
            return "a table"
    return "anything"


def in_range(root: Node, node: Node, value: float) -> bool:
    """Return whether a number is within the bounds of its node."""
    holds = {
        "exclusiveMinimum": float.__gt__,
        "minimum": float.__ge__,
        "exclusiveMaximum": float.__lt__,
        "maximum": float.__le__,
    }
    node = resolved(root, node)
    return all(check(float(value), float(node[name])) for name, check in holds.items() if name in node)


def _bounds(node: Node) -> str:
    return " and ".join(f"{sign} {node[name]:g}" for name, sign in _BOUNDS if name in node)


def _array_in_words(root: Node, node: Node) -> str:
    low, high = node.get("minItems", 0), node.get("maxItems")
    count = f"{low}" if low == high else f"{low} to {high}" if high else f"{low} or more" if low else ""
    each = [in_words(root, item) for item in node.get("prefixItems", ())] or [in_words(root, node.get("items", {}))]
    kinds = {word.split(" ", 2)[1] if word.startswith("a whole") else word.split(" ")[1] for word in each}
    if all(word.startswith(("a number", "a whole number")) for word in each) and len(kinds) == 1:
        bounds = each[0].removeprefix("a whole number").removeprefix("a number") if len(set(each)) == 1 else ""
        return f"{count or 'any number of'} {'whole numbers' if 'whole' in kinds else 'numbers'}{bounds}"
    if each[0].endswith("numbers"):
        return f"{count or 'any number of'} lists of {each[0]}"
    return f"{count or 'any number of'} times {each[0]}" if len(set(each)) == 1 else f"[{', '.join(each)}]"
