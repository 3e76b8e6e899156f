"""Values that may change along a section: a number, a few, or a table of rows [s, value, ...]."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeGuard

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import core_schema

from tendond.schemas.errors.keywords import WORDS

Rows = tuple[tuple[float, ...], ...]
Along = float | tuple[float, ...] | Rows
"""One number, one per axis, or rows (s [m], values...)."""


@dataclass(frozen=True)
class Varies:
    """Rule of a key whose value may change along its section, for `Annotated[Along, Varies(...)]`.

    Attributes:
        width: numbers at one place.
        low, high: range of each; low_allowed: the lower bound belongs to it.
        scalar: one number may stand for all of them.
    """

    width: int = 1
    low: float = 0.0
    high: float = math.inf
    low_allowed: bool = False
    scalar: bool = True

    @property
    def words(self) -> str:
        """Allowed values, for people."""
        sign = ">=" if self.low_allowed else ">"
        bounds = "" if self.low == -math.inf else f" {sign} {self.low:g}"
        bounds += "" if self.high == math.inf else f" and <= {self.high:g}"
        forms = (["a number"] if self.scalar else []) + ([f"{self.width} numbers"] if self.width > 1 else [])
        row = "[s, value]" if self.width == 1 else f"[s, {', '.join('xyz'[: self.width])}]"
        return f"{' or '.join(forms)}{bounds}, or a table of rows {row}"

    def check(self, value: object) -> Along:
        """Return the value with floats and tuples.

        Raises:
            ValueError: it has another form, or is out of range.
        """
        found = self._read(value)
        if found is None or not all(self._allowed(one) for one in _numbers(found)):
            raise ValueError(f"must be {self.words}")
        if is_table(found):
            places = [row[0] for row in _table(found)]
            if places[0] < 0.0 or any(left >= right for left, right in pairwise(places)):
                raise ValueError("s must ascend from row to row, from the section's base on")
        return found

    def _allowed(self, one: float) -> bool:
        above = one >= self.low if self.low_allowed else one > self.low
        return math.isfinite(one) and above and one <= self.high

    def _read(self, value: object) -> Along | None:
        if _is_number(value):
            return float(value) if self.scalar else None
        if not isinstance(value, list | tuple) or not value:
            return None
        if all(_is_number(one) for one in value):
            return tuple(float(one) for one in value) if self.width > 1 and len(value) == self.width else None
        if not all(isinstance(row, list | tuple) and all(_is_number(one) for one in row) for row in value):
            return None
        widths = {1 + self.width, *({2} if self.scalar else ())}
        if len(value) < 2 or len({len(row) for row in value}) != 1 or len(value[0]) not in widths:
            return None
        return tuple(tuple(float(one) for one in row) for row in value)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        """Validate by `check`."""
        return core_schema.no_info_plain_validator_function(self.check)

    def __get_pydantic_json_schema__(self, schema: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Describe both forms, and the same in words."""
        return {"anyOf": [{"type": "number"}, {"type": "array"}], WORDS: self.words}


def is_table(value: Along) -> bool:
    """True if a value is a table, not a constant."""
    return isinstance(value, tuple) and isinstance(value[0], tuple)


def constant_of(value: Along, width: int) -> tuple[float, ...] | None:
    """Return the numbers of a value that does not change, shape (width,); none for one that does."""
    if isinstance(value, float):
        return (value,) * width
    if not is_table(value):
        return _row(value)
    rows = rows_of(value, width)
    return rows[0][1:] if all(row[1:] == rows[0][1:] for row in rows) else None


def rows_of(value: Along, width: int) -> Rows:
    """Return the rows of a table, each with `width` values behind s."""
    return tuple(row if len(row) == 1 + width else (row[0], *(row[1],) * width) for row in _table(value))


def first_of(value: Along, width: int) -> tuple[float, ...]:
    """Return the values at the section's base, shape (width,)."""
    return rows_of(value, width)[0][1:] if is_table(value) else constant_of(value, width) or ()


def end_of(value: Along) -> float:
    """Return s of a table's last row [m]; 0 for a constant."""
    return _table(value)[-1][0] if is_table(value) else 0.0


def _is_number(value: object) -> TypeGuard[int | float]:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _table(value: Along) -> Rows:
    assert isinstance(value, tuple)
    rows: list[tuple[float, ...]] = []
    for row in value:
        assert isinstance(row, tuple)
        rows.append(row)
    return tuple(rows)


def _row(value: tuple[float, ...] | Rows) -> tuple[float, ...]:
    """Return the numbers of a value that is no table."""
    return tuple(one for one in value if not isinstance(one, tuple))


def _numbers(value: Along) -> tuple[float, ...]:
    if isinstance(value, float):
        return (value,)
    if is_table(value):
        return tuple(one for row in _table(value) for one in row[1:])
    return _row(value)
