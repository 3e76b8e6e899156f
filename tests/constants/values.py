"""Values of the constants that an experiment runs, and its table."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

NONE = 1e9
"""Value of a bound that bounds nothing."""

Neighbours = Mapping[str, tuple[Any, ...]]
"""Values to run beside a constant's own, by its name."""


def values_of(names: Sequence[str], own: Mapping[str, Any], table: Neighbours) -> list[tuple[str, Any]]:
    """List the values to run: one constant's own, then the others of each."""
    listed = [name for name in names if name in table]
    return [(name, own[name]) for name in listed[:1]] + [(name, value) for name in listed for value in table[name]]


def in_words(value: Any) -> str:
    """Write a value, or several, as in a table."""
    return ", ".join(f"{one:g}" for one in (value if isinstance(value, tuple) else (value,)))


def print_table(columns: Sequence[str], rows: Iterator[list[str]]) -> None:
    """Print a table row by row."""
    print(f"| {' | '.join(columns)} |\n|{' --- |' * len(columns)}")
    for row in rows:
        print(f"| {' | '.join(row)} |", flush=True)
    print()
