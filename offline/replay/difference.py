"""Comparison of two records of a cycle, field by field, as they are in the log."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

MISSING = "(not there)"

SOLVER = ("model.residual", "model.marches")
"""Fields on how a solution was found, which depends on the processor: not compared within a tolerance."""


@dataclass(frozen=True)
class Field:
    """A field that differs: its path, and both values as JSON has them."""

    path: str
    logged: Any
    replayed: Any

    def __str__(self) -> str:
        return f"{self.path}: {_shown(self.logged)} in the log, {_shown(self.replayed)} replayed"


@dataclass(frozen=True)
class Difference:
    """A cycle that came out otherwise: its tick, and each field that differs."""

    tick: int
    fields: tuple[Field, ...]


def compare(logged: str | bytes, replayed: str | bytes, tolerance: float | None = None) -> tuple[Field, ...]:
    """List the fields that differ between two JSON texts.

    Args:
        logged, replayed: the texts.
        tolerance: tolerance of numbers with a fraction: absolute below 1, relative above. None: not at all, and
            0.0 is not -0.0.
    """
    found = tuple(_fields("", json.loads(logged), json.loads(replayed), tolerance))
    return tuple(field for field in found if tolerance is None or field.path not in SOLVER)


def _fields(path: str, a: Any, b: Any, tolerance: float | None) -> Iterator[Field]:
    if isinstance(a, dict) and isinstance(b, dict):
        for key in [*a, *(key for key in b if key not in a)]:
            yield from _fields(f"{path}.{key}" if path else key, a.get(key, MISSING), b.get(key, MISSING), tolerance)
    elif isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        for i, (one, other) in enumerate(zip(a, b, strict=True)):
            yield from _fields(f"{path}[{i}]", one, other, tolerance)
    elif not _equal(a, b, tolerance):
        yield Field(path, a, b)


def _equal(a: Any, b: Any, tolerance: float | None) -> bool:
    if isinstance(a, float) and isinstance(b, float) and tolerance is not None:
        return abs(a - b) <= tolerance * max(1.0, abs(a), abs(b))
    return repr(a) == repr(b)


def _shown(value: Any) -> str:
    text = value if value == MISSING else json.dumps(value)
    return text if len(text) <= 80 else text[:77] + "..."
